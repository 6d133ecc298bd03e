/*
 * The runtime of reduced-order models of flexible bodies that fly, for C and C++.
 *
 * SI units. Frame G is inertial, frame A is attached to the reference node of the body; both have the axes of the structure
 * file at the start. Quaternions have their scalar first and turn components in A into components in G. Matrices are
 * row-major.
 *
 * Errors: functions that can fail return a rom_status, ROM_OK being zero; rom_last_error() then says in words what was
 * found, what was expected and what to do. Nothing is written to outputs when a function fails. Null pointers, wrong sizes
 * and numbers that are not finite are refused, not undefined.
 *
 * Threads: a rom_model never changes and may be used by any number of threads at once. Every other handle may be used by
 * one thread at a time, whichever it is; different handles do not share anything that changes. rom_last_error() is of the
 * calling thread.
 *
 * Memory: every handle is freed by its own function, in any order: a simulation keeps what it needs of its model. Freeing
 * NULL does nothing. Stepping and reading outputs neither allocate nor lock, even when they fail.
 *
 * Structures start with their size, `struct_size = sizeof(...)`, set by the caller: a program built against an older header
 * goes on working with a newer library.
 */
/* Made by cbindgen from the Rust sources; do not edit. */


#ifndef ROM_H
#define ROM_H

#include <stddef.h>
#include <stdint.h>

// What became of a call.
typedef enum rom_status {
    // Done.
    ROM_OK = 0,
    // An argument is null, of the wrong size, out of range or not finite.
    ROM_BAD_ARGUMENT = 1,
    // There is no point, load case or slot of that name or number.
    ROM_NOT_FOUND = 2,
    // The model file cannot be read, is damaged, is of another version, or holds no model that makes sense.
    ROM_BAD_MODEL = 3,
    // Settings, loads or a state that do not fit the model.
    ROM_BAD_SETTINGS = 4,
    // A step did not converge; the state is the one before it.
    ROM_NOT_CONVERGED = 5,
    // A step diverged; the state is the one before it.
    ROM_DIVERGED = 6,
    // A defect of the library. The handles of the call may only be freed.
    ROM_INTERNAL = 7,
} rom_status;

// How a simulation is marched.
typedef enum rom_integrator {
    // Newmark: implicit, any step.
    ROM_NEWMARK = 0,
    // Classical Runge-Kutta: explicit, fourth order, limited step (rom_model_stable_dt), same work every step.
    ROM_RK4 = 1,
    // Generalised-alpha: implicit, any step, second order with numerical damping.
    ROM_GENERALIZED_ALPHA = 2,
    // Energy-momentum: implicit, any step, for models with consistent inertia in free flight. Keeps energy and momenta.
    ROM_ENERGY_MOMENTUM = 3,
} rom_integrator;

// How the equations of a model are simplified.
typedef enum rom_method {
    // The reduced model: all couplings.
    ROM_METHOD_ROM = 0,
    // Oscillators and a rigid body, coupled only by the loads.
    ROM_METHOD_MEAN_AXES = 1,
    // The rigid body alone.
    ROM_METHOD_RIGID = 2,
} rom_method;

// Axes in which the components of a wrench are given, and stay constant during a step.
typedef enum rom_frame {
    // Inertial frame G: dead loads.
    ROM_FRAME_DEAD = 0,
    // Body frame A.
    ROM_FRAME_BODY = 1,
    // Axes that turn with the node of the point, those of A in the drawing: follower loads.
    ROM_FRAME_NODE = 2,
} rom_frame;

// Axes in which the motion of stations is given.
typedef enum rom_station_axes {
    // Everything in G.
    ROM_STATION_INERTIAL = 0,
    // In A: positions from its origin, attitudes against it; velocities are against G, components in A.
    ROM_STATION_BODY = 1,
    // Positions and attitudes in A; velocities are against G, components in the axes of every section.
    ROM_STATION_SECTION = 2,
} rom_station_axes;

// Memory of the evaluation of the equations of motion.
typedef struct rom_evaluator rom_evaluator;

// Loads on the points of a model.
typedef struct rom_loads rom_loads;

// A reduced model. Never changes; may be used by any number of threads at once.
typedef struct rom_model rom_model;

// A model in motion.
typedef struct rom_simulation rom_simulation;

// A block of stations made ready for reading.
typedef struct rom_stations rom_stations;

// What the author of a load case ran it with.
typedef struct rom_load_case {
    // Set to `sizeof(rom_load_case)` before the call.
    uint64_t struct_size;
    // End of the run, s.
    double t_end;
    // Time step, s.
    double dt;
    // Numerical damping of the implicit integrators.
    double numerical_damping;
} rom_load_case;

// Where the parts of a state are in its array of numbers. All of a state is in it: a simulation that goes on from a copy
// gives the same bits. `m` is the number of elastic modes.
typedef struct rom_state_layout {
    // Set to `sizeof(rom_state_layout)` before the call.
    uint64_t struct_size;
    // Length of the array.
    uint64_t size;
    // Time, s (1).
    uint64_t time;
    // What rounding has taken from the time, s (1).
    uint64_t time_carry;
    // Modal amplitudes (m).
    uint64_t q;
    // Modal rates, 1/s (m).
    uint64_t q_dot;
    // Rigid part of the velocity of A in A, m/s and rad/s (6). The true velocity, that of rom_rigid, is the sum of it and
    // of what the modal rates move A by.
    uint64_t beta_star;
    // Attitude quaternion, scalar first (4).
    uint64_t attitude;
    // Position of the origin of A in G, m (3).
    uint64_t position;
    // 1 when the accelerations below belong to the rest, 0 when they do not: set 0 after changing anything by hand, and
    // the next step solves them anew (1).
    uint64_t accelerations_known;
    // Modal accelerations and rates of beta_star (m + 6).
    uint64_t u_dot;
    // What the implicit methods carry from step to step (m + 6; with consistent inertia 2 m + 27).
    uint64_t algorithmic;
} rom_state_layout;

// Motion of frame A.
typedef struct rom_rigid {
    // Set to `sizeof(rom_rigid)` before the call.
    uint64_t struct_size;
    // Time, s.
    double time;
    // Position of the origin of A in G, m.
    double r_g[3];
    // Velocity of the origin of A, components in A, m/s.
    double v_a[3];
    // Angular velocity of A, components in A, rad/s.
    double w_a[3];
    // Velocity of the origin of A, components in G, m/s.
    double v_g[3];
    // Angular velocity of A, components in G, rad/s.
    double w_g[3];
    // Attitude quaternion, scalar first.
    double zeta[4];
} rom_rigid;

// Where a named point is.
typedef struct rom_point {
    // Set to `sizeof(rom_point)` before the call.
    uint64_t struct_size;
    // Displacement from the equilibrium, components in A, m.
    double dr_a[3];
    // Position in G, m.
    double r_g[3];
} rom_point;

// The quantities whose balance tells whether a result can be trusted.
typedef struct rom_ledger {
    // Set to `sizeof(rom_ledger)` before the call.
    uint64_t struct_size;
    // Centre of mass in G, m.
    double r_cm_g[3];
    // Linear momentum in G, kg m/s.
    double linear_momentum_g[3];
    // Angular momentum in G about the origin of G, kg m^2/s.
    double angular_momentum_g[3];
    // Kinetic energy, J.
    double kinetic_energy;
    // Elastic energy of the kept modes, J.
    double elastic_energy;
    // Potential energy in the field of gravity, zero with the centre of mass at the origin of G, J.
    double gravity_energy;
} rom_ledger;

// How a named point moves, seen from G.
typedef struct rom_point_motion {
    // Set to `sizeof(rom_point_motion)` before the call.
    uint64_t struct_size;
    // Attitude quaternion of the point's node, whose axes are those of the drawing at rest, scalar first, node to G.
    double zeta[4];
    // Velocity, components in G, m/s.
    double v_g[3];
    // Angular velocity of the node, components in G, rad/s.
    double w_g[3];
    // Acceleration, components in G, m/s^2.
    double a_g[3];
    // Angular acceleration of the node, components in G, rad/s^2.
    double alpha_g[3];
} rom_point_motion;

// What an inertial sensor reads, in its own axes.
typedef struct rom_sensor_reading {
    // Set to `sizeof(rom_sensor_reading)` before the call.
    uint64_t struct_size;
    // Acceleration, less that of free fall where the sensor feels gravity, m/s^2.
    double a[3];
    // Angular velocity, rad/s.
    double w[3];
    // Angular acceleration, rad/s^2.
    double alpha[3];
} rom_sensor_reading;

// How far a run is estimated to be from the body that its model stands for: relative errors so far, the largest length of
// the error over the largest of the quantity; and how much of the range of the model is used.
typedef struct rom_error_estimate {
    // Set to `sizeof(rom_error_estimate)` before the call.
    uint64_t struct_size;
    // Error indicator: the largest of the three errors.
    double indicator;
    // Of the velocity of A in G.
    double v_g;
    // Of the angular velocity of A in G.
    double w_g;
    // Of the displacements of the named points.
    double dr_a;
    // Largest amplitude now over the one at which the terms left out reach a tenth of those kept.
    double amplitude;
    // Largest angular rate now over the one at which the centrifugal terms left out reach a tenth of the stiffness.
    double rate;
} rom_error_estimate;

// Settings of a simulation. rom_settings_init gives the defaults.
typedef struct rom_settings {
    // Set to `sizeof(rom_settings)` before any call.
    uint64_t struct_size;
    // Time step, s. Default: 0.01.
    double dt;
    // Numerical damping of the implicit integrators, 0 to 1; zero for RK4. Default: 0.
    double numerical_damping;
    // A rom_integrator. Default: ROM_NEWMARK.
    uint32_t integrator;
    // Most iterations of an implicit step, 1 to 1000: bounds its time. Default: 40.
    uint32_t max_iterations;
} rom_settings;

// Motion of frame A, prescribed by a host that carries the rigid body itself.
typedef struct rom_motion {
    // Set to `sizeof(rom_motion)` before the call.
    uint64_t struct_size;
    // Velocity of the origin of A and angular velocity of A, components in A, m/s and rad/s.
    double velocity[6];
    // Rates of these components, m/s^2 and rad/s^2. The inertial acceleration of the origin is `v_dot + w x v`.
    double rate[6];
    // Attitude quaternion, scalar first.
    double attitude[4];
    // Position of the origin of A in G, m.
    double position[3];
} rom_motion;

// What the body does to the host that moves its frame A: wrenches (force in N, moment in N m) on the host about the
// origin of A, components in A. A host without inertia of the body accelerates by the sum of the three; one that carries
// mass and inertia of the undeformed body, by loads + increment (the sum, exchanged explicitly, diverges with a host
// lighter than the body).
typedef struct rom_reaction {
    // Set to `sizeof(rom_reaction)` before the call.
    uint64_t struct_size;
    // Inertia of the undeformed body in the prescribed motion.
    double inertia[6];
    // Resultant of the loads at the deformed points.
    double loads[6];
    // What elasticity adds.
    double increment[6];
} rom_reaction;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// An evaluator for a model. Free it with rom_evaluator_free.
enum rom_status rom_evaluator_new(const struct rom_model *model, struct rom_evaluator **evaluator);

// Frees an evaluator.
void rom_evaluator_free(struct rom_evaluator *evaluator);

// Number of variables of the equations of motion of a model, 2 m + 13: `q` (m), `q_dot` (m), `beta_star` (6), `attitude`
// (4), `position` (3), as in rom_state_layout. 0 for NULL.
size_t rom_model_n_variables(const struct rom_model *model);

// `y_dot = f(t, y)` under the loads: `y` and `y_dot` have the `n` variables of rom_model_n_variables, in their order. The
// attitude need not be of unit length: its direction counts. Finite `y` may still give a `y_dot` that is not, where a load
// has no finite value.
enum rom_status rom_evaluator_derivatives(struct rom_evaluator *evaluator,
                                          double t,
                                          const double *y,
                                          size_t n,
                                          const struct rom_loads *loads,
                                          double *y_dot);

// Number of tangent coordinates of a model, 2 m + 12: `q` (m), `q_dot` (m), `beta_star` (6), a small turn of A about its own axes (3,
// rad), the position of its origin in G (3, m). 0 for NULL.
size_t rom_model_n_tangent(const struct rom_model *model);

// Exact derivative of the rates of the tangent coordinates by themselves at `y`, under the loads, into `matrix`: `entries` of them, the
// square of rom_model_n_tangent, row by row. The rate of the turn is relative to the motion at hand, `dw - w x turn`.
enum rom_status rom_evaluator_jacobian(struct rom_evaluator *evaluator,
                                       double t,
                                       const double *y,
                                       size_t n,
                                       const struct rom_loads *loads,
                                       double *matrix,
                                       size_t entries);

// Derivative of the rates of the tangent coordinates by a factor on `loads`, at the place of the last rom_evaluator_jacobian, into `column`
// with the `n` entries of rom_model_n_tangent: what these loads add. With one unit force among the loads it is the column of that force.
enum rom_status rom_evaluator_by_load(struct rom_evaluator *evaluator,
                                      const struct rom_loads *loads,
                                      double *column,
                                      size_t n);

// Loads for a model: those of a load case, and wrenches on the `n` points of numbers `points`, each given once, which are zero until
// rom_loads_add adds to them. Wrench `slot` acts on `points[slot]`. `load_case` is the name of one, which about a loaded equilibrium
// brings the loads of the equilibrium along; "" for the loads of the equilibrium alone; NULL for none at all, so that the host gives
// those of the equilibrium too. Free the loads with rom_loads_free.
enum rom_status rom_loads_new(const struct rom_model *model,
                              const char *load_case,
                              const size_t *points,
                              size_t n,
                              struct rom_loads **loads);

// Frees loads.
void rom_loads_free(struct rom_loads *loads);

// Makes all wrenches zero. A load case goes on acting.
enum rom_status rom_loads_clear(struct rom_loads *loads);

// Adds a force (N, 3) and a moment (N m, 3) on a slot, components in `frame` (rom_frame). The implicit integrators take
// wrenches as those at the end of a step, RK4 holds them over the step.
enum rom_status rom_loads_add(struct rom_loads *loads,
                              size_t slot,
                              uint32_t frame,
                              const double *force,
                              const double *moment);

// Adds a follower force (N, 3) and moment (N m, 3) with components in a section frame that turns with the node:
// `section` is its rotation matrix, row-major (9), section components to node components.
enum rom_status rom_loads_add_in_section(struct rom_loads *loads,
                                         size_t slot,
                                         const double *section,
                                         const double *force,
                                         const double *moment);

// Adds a force (N, 3) on the origin of frame A and a moment (N m, 3), components in `frame` (rom_frame; the axes of A's node are
// those of A): what acts on the body as a whole.
enum rom_status rom_loads_add_wrench(struct rom_loads *loads,
                                     uint32_t frame,
                                     const double *force,
                                     const double *moment);

// Adds generalised forces on the elastic modes, N m per unit amplitude (n), one for each of the model's `n` modes: the work of loads
// in their shapes. What the same loads do to the rigid motion goes by rom_loads_add_wrench.
enum rom_status rom_loads_add_modal(struct rom_loads *loads,
                                    const double *forces,
                                    size_t n);

// Reads a model file. `path` is UTF-8. Free the model with rom_model_free.
enum rom_status rom_model_read(const char *path, struct rom_model **model);

// A model from the bytes of its file, which may be given back afterwards. Free the model with rom_model_free.
enum rom_status rom_model_from_bytes(const uint8_t *bytes, size_t length, struct rom_model **model);

// The same body by a simpler method (rom_method), as a model of its own. A simplified model cannot be turned back.
enum rom_status rom_model_with_method(const struct rom_model *model,
                                      uint32_t method,
                                      struct rom_model **simpler);

// Frees a model. What was made from it stays valid.
void rom_model_free(struct rom_model *model);

// Number of elastic modes m. The model has m + 6 degrees of freedom. 0 for NULL.
size_t rom_model_n_modes(const struct rom_model *model);

// Number of named points. 0 for NULL.
size_t rom_model_n_points(const struct rom_model *model);

// Number of load cases. 0 for NULL.
size_t rom_model_n_load_cases(const struct rom_model *model);

// Name of a point, NULL where there is none. Valid as long as the model.
const char *rom_model_point_name(const struct rom_model *model, size_t point);

// Name of a load case, NULL where there is none. Valid as long as the model.
const char *rom_model_load_case_name(const struct rom_model *model, size_t load_case);

// What a load case is about, NULL where there is none. Valid as long as the model.
const char *rom_model_load_case_description(const struct rom_model *model, size_t load_case);

// Number of the point of this name.
enum rom_status rom_model_find_point(const struct rom_model *model, const char *name, size_t *point);

// Axes of a member's section at the point of number `point`, as rom_loads_add_in_section takes them: rotation matrix, row by row,
// section components to node components; `n` has to be 9. `member` may be NULL where all members at the point have the same axes.
enum rom_status rom_model_section_axes(const struct rom_model *model,
                                       size_t point,
                                       const char *member,
                                       double *matrix,
                                       size_t n);

// Acceleration of free fall in G, m/s^2 (`n` has to be 3), under which the model is marched: zero in weightlessness.
enum rom_status rom_model_gravity(const struct rom_model *model,
                                  double *acceleration,
                                  size_t n);

// Settings of the load case of this name.
enum rom_status rom_model_load_case(const struct rom_model *model,
                                    const char *name,
                                    struct rom_load_case *load_case);

// Circular frequencies of the elastic modes, rad/s: `n` has to be their number.
enum rom_status rom_model_frequencies(const struct rom_model *model, double *omega, size_t n);

// Mass matrix of the rigid body about the origin of A, row by row, v before w: `n` has to be 36.
enum rom_status rom_model_mass_matrix(const struct rom_model *model, double *matrix, size_t n);

// Inertia about the origin of A with the modes free to respond, which is what a sudden acceleration meets: row by row, v before
// w; `n` has to be 36. Refused for mean axes.
enum rom_status rom_model_apparent_inertia(const struct rom_model *model,
                                           double *matrix,
                                           size_t n);

// Longest stable time step of an integrator (rom_integrator), s; infinite for those that have no limit.
enum rom_status rom_model_stable_dt(const struct rom_model *model, uint32_t integrator, double *dt);

// Layout of the states of a model.
enum rom_status rom_model_state_layout(const struct rom_model *model, struct rom_state_layout *layout);

// Time and motion of frame A.
enum rom_status rom_simulation_rigid(const struct rom_simulation *simulation, struct rom_rigid *rigid);

// Where the point of this number is.
enum rom_status rom_simulation_point(const struct rom_simulation *simulation,
                                     size_t point,
                                     struct rom_point *out);

// Centre of mass, momenta and energies.
enum rom_status rom_simulation_ledger(const struct rom_simulation *simulation, struct rom_ledger *ledger);

// How the point of this number moves: attitude, velocities, accelerations. Accelerations are those at the end of the last step; where
// the state has none (at the start, after RK4, where a state was set) they are solved under `loads`.
enum rom_status rom_simulation_point_motion(struct rom_simulation *simulation,
                                            const struct rom_loads *loads,
                                            size_t point,
                                            struct rom_point_motion *out);

// Number of inertial sensors. 0 for NULL.
size_t rom_model_n_sensors(const struct rom_model *model);

// Name of a sensor, NULL where there is none. Valid as long as the model.
const char *rom_model_sensor_name(const struct rom_model *model, size_t sensor);

// Number of the sensor of this name.
enum rom_status rom_model_find_sensor(const struct rom_model *model, const char *name, size_t *sensor);

// What the sensor of this number reads. Accelerations as for rom_simulation_point_motion.
enum rom_status rom_simulation_sensor(struct rom_simulation *simulation,
                                      const struct rom_loads *loads,
                                      size_t sensor,
                                      struct rom_sensor_reading *out);

// Estimates errors from now on, looking at the motion every so many steps (`romrun`: 12), 0 turns it off. Allocates. Setting
// a state and prescribed motion begin the estimate again.
enum rom_status rom_simulation_watch_errors(struct rom_simulation *simulation,
                                            uint32_t every);

// Estimated errors of the run so far. ROM_NOT_FOUND unless they are watched.
enum rom_status rom_simulation_error_estimate(const struct rom_simulation *simulation,
                                              struct rom_error_estimate *estimate);

// Number of places of internal loads. 0 for NULL.
size_t rom_model_n_sections(const struct rom_model *model);

// Name of a place of internal loads, NULL where there is none. Valid as long as the model.
const char *rom_model_section_name(const struct rom_model *model, size_t section);

// Number of the place of internal loads of this name.
enum rom_status rom_model_find_section(const struct rom_model *model, const char *name, size_t *section);

// Force (N) and moment (N m) on the positive face of the section at every place of internal loads, in the axes of the deformed section,
// at the present state under these loads: `n` has to be 6 times their number. By summation of forces where the model has what that
// takes, else by the strains of the modes. Where the accelerations of the state are not known they are solved.
enum rom_status rom_simulation_section_forces(struct rom_simulation *simulation,
                                              const struct rom_loads *loads,
                                              double *forces,
                                              size_t n);

// Settings by default. `struct_size` has to be set before.
enum rom_status rom_settings_init(struct rom_settings *settings);

// A simulation at rest, undeformed, at t = 0. `settings` may be NULL for the defaults. Allocates everything it will ever
// need. Free it with rom_simulation_free.
enum rom_status rom_simulation_new(const struct rom_model *model,
                                   const struct rom_settings *settings,
                                   struct rom_simulation **simulation);

// Frees a simulation.
void rom_simulation_free(struct rom_simulation *simulation);

// Sets the state in which the load case of this name starts, at t = 0: where the structure file gives it initial conditions, there; else
// at rest. Allocates.
enum rom_status rom_simulation_start(struct rom_simulation *simulation,
                                     const char *load_case);

// Sets the acceleration of free fall in G (m/s^2, 3) from the next step on; it begins as rom_model_gravity, and is no part of the state.
enum rom_status rom_simulation_set_gravity(struct rom_simulation *simulation,
                                           const double *acceleration);

// One time step. If it fails, the state is the one before it.
enum rom_status rom_simulation_step(struct rom_simulation *simulation, const struct rom_loads *loads);

// `n` time steps with the same wrenches. Stops at the first that fails, with the state before that one.
enum rom_status rom_simulation_run(struct rom_simulation *simulation,
                                   const struct rom_loads *loads,
                                   uint64_t n);

// Begins a motion of frame A that the host prescribes: takes over its velocity, attitude and position at the present time.
// Amplitudes and rates of the modes stay. Not for mean-axes models.
enum rom_status rom_simulation_prescribe(struct rom_simulation *simulation,
                                         const struct rom_loads *loads,
                                         const struct rom_motion *motion);

// One time step in which the host moves frame A, to `motion` at the end of the step; only the modes are marched. Call
// rom_simulation_prescribe before the first. If it fails, the state is the one before it.
enum rom_status rom_simulation_step_prescribed(struct rom_simulation *simulation,
                                               const struct rom_loads *loads,
                                               const struct rom_motion *motion);

// What the body does to the host at the end of the last prescribed step. ROM_NOT_FOUND in free flight.
enum rom_status rom_simulation_reaction(const struct rom_simulation *simulation,
                                        struct rom_reaction *reaction);

// Copies the state out: a snapshot. `n` has to be the size of rom_state_layout.
enum rom_status rom_simulation_get_state(const struct rom_simulation *simulation, double *state, size_t n);

// Goes on from a state: a snapshot, for the same bits as before, or initial conditions (then `accelerations_known` has to
// be 0). A state that makes no sense is refused, and the simulation stays where it is.
enum rom_status rom_simulation_set_state(struct rom_simulation *simulation,
                                         const double *state,
                                         size_t n);

// Number of blocks of stations. 0 for NULL.
size_t rom_model_n_station_blocks(const struct rom_model *model);

// Name of a block of stations, NULL where there is none. Valid as long as the model.
const char *rom_model_station_block_name(const struct rom_model *model, size_t block);

// Number of the block of stations of this name.
enum rom_status rom_model_find_station_block(const struct rom_model *model, const char *name, size_t *block);

// Makes a block of stations of a model ready for reading: everything is allocated here. Free it with rom_stations_free.
enum rom_status rom_stations_new(const struct rom_model *model,
                                 size_t block,
                                 struct rom_stations **stations);

// Frees stations.
void rom_stations_free(struct rom_stations *stations);

// Number of stations. 0 for NULL.
size_t rom_stations_count(const struct rom_stations *stations);

// Where the stations are and how they move now, in `axes` (rom_station_axes), station after station: positions in m (3 n), attitudes
// of the section axes as unit quaternions, scalar first (4 n), velocities in m/s (3 n), angular velocities in rad/s (3 n). `n` has to
// be rom_stations_count; any of the arrays may be NULL. The simulation has to be one of the model of the stations. Does not allocate.
enum rom_status rom_stations_read(struct rom_stations *stations,
                                  const struct rom_simulation *simulation,
                                  uint32_t axes,
                                  size_t n,
                                  double *position,
                                  double *attitude,
                                  double *velocity,
                                  double *angular_velocity);

// As rom_loads_new, with `n_blocks` blocks of stations (numbers `blocks`, each given once) that can be loaded besides the points. What
// acts on them is zero until rom_loads_set_stations sets it.
enum rom_status rom_loads_new_with_stations(const struct rom_model *model,
                                            const char *load_case,
                                            const size_t *points,
                                            size_t n,
                                            const size_t *blocks,
                                            size_t n_blocks,
                                            struct rom_loads **loads);

// Replaces what acts on the `slot`-th block given to rom_loads_new_with_stations: force (N) and moment (N m) on every station (6 n),
// at the stations, components in `frame` (rom_frame; ROM_FRAME_NODE
// stands for the axes of every section). `n` is the number of stations of the block. Does not allocate.
enum rom_status rom_loads_set_stations(struct rom_loads *loads,
                                       size_t slot,
                                       uint32_t frame,
                                       const double *wrenches,
                                       size_t n);

// What the last function that failed on this thread says about it, in one or more sentences (UTF-8). Empty if none has.
// Never null. Valid until the next failure on this thread.
const char *rom_last_error(void);

// A status in words. Never null; constant.
const char *rom_status_text(int32_t status);

// Version of the library, "major.minor.patch". Below 1.0 programs have to be built again for another minor version.
// Constant.
const char *rom_version(void);

// Newest version of the model file that this library reads: `1000 major + minor`. It reads all older ones of the same
// major version.
uint32_t rom_format_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ROM_H */
