// The runtime for C++11 and newer: handles that free themselves, errors as exceptions. Header only, on top of rom.h, which
// says what everything means.
#ifndef ROM_HPP
#define ROM_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "rom.h"

namespace rom {

using Vector = std::array<double, 3>;

// What went wrong, in words; status() for programs.
class Error : public std::runtime_error {
public:
    explicit Error(rom_status status) : std::runtime_error(rom_last_error()), status_(status) {}
    rom_status status() const noexcept { return status_; }

private:
    rom_status status_;
};

inline void check(rom_status status) {
    if (status != ROM_OK) throw Error(status);
}

namespace detail {
struct Free {
    void operator()(rom_model *p) const noexcept { rom_model_free(p); }
    void operator()(rom_loads *p) const noexcept { rom_loads_free(p); }
    void operator()(rom_simulation *p) const noexcept { rom_simulation_free(p); }
    void operator()(rom_evaluator *p) const noexcept { rom_evaluator_free(p); }
    void operator()(rom_stations *p) const noexcept { rom_stations_free(p); }
};
template <class T> using Handle = std::unique_ptr<T, Free>;

// A structure of rom.h that knows its size.
template <class T> T sized() {
    T value{};
    value.struct_size = sizeof(T);
    return value;
}
} // namespace detail

// Never changes; copies share it, also between threads.
class Model {
public:
    static Model read(const std::string &path) {
        rom_model *model = nullptr;
        check(rom_model_read(path.c_str(), &model));
        return Model(model);
    }
    static Model from_bytes(const std::uint8_t *bytes, std::size_t length) {
        rom_model *model = nullptr;
        check(rom_model_from_bytes(bytes, length, &model));
        return Model(model);
    }
    Model with_method(rom_method method) const {
        rom_model *model = nullptr;
        check(rom_model_with_method(get(), method, &model));
        return Model(model);
    }
    std::size_t n_modes() const noexcept { return rom_model_n_modes(get()); }
    std::size_t n_points() const noexcept { return rom_model_n_points(get()); }
    std::size_t point(const std::string &name) const {
        std::size_t point = 0;
        check(rom_model_find_point(get(), name.c_str(), &point));
        return point;
    }
    std::size_t station_block(const std::string &name) const {
        std::size_t block = 0;
        check(rom_model_find_station_block(get(), name.c_str(), &block));
        return block;
    }
    // Places of internal loads.
    std::size_t n_sections() const noexcept { return rom_model_n_sections(get()); }
    std::size_t section(const std::string &name) const {
        std::size_t section = 0;
        check(rom_model_find_section(get(), name.c_str(), &section));
        return section;
    }
    std::size_t sensor(const std::string &name) const {
        std::size_t sensor = 0;
        check(rom_model_find_sensor(get(), name.c_str(), &sensor));
        return sensor;
    }
    // Axes of a member's section at a point, for Loads::add_in_section; no name where all members there have the same.
    std::array<double, 9> section_axes(std::size_t point, const std::string &member = "") const {
        std::array<double, 9> axes{};
        check(rom_model_section_axes(get(), point, member.empty() ? nullptr : member.c_str(), axes.data(), axes.size()));
        return axes;
    }
    // Acceleration of free fall in G.
    Vector gravity() const {
        Vector acceleration{};
        check(rom_model_gravity(get(), acceleration.data(), acceleration.size()));
        return acceleration;
    }
    rom_load_case load_case(const std::string &name) const {
        auto load_case = detail::sized<rom_load_case>();
        check(rom_model_load_case(get(), name.c_str(), &load_case));
        return load_case;
    }
    std::vector<double> frequencies() const {
        std::vector<double> omega(n_modes());
        check(rom_model_frequencies(get(), omega.data(), omega.size()));
        return omega;
    }
    std::array<double, 36> mass_matrix() const {
        std::array<double, 36> matrix{};
        check(rom_model_mass_matrix(get(), matrix.data(), matrix.size()));
        return matrix;
    }
    std::array<double, 36> apparent_inertia() const {
        std::array<double, 36> matrix{};
        check(rom_model_apparent_inertia(get(), matrix.data(), matrix.size()));
        return matrix;
    }
    rom_state_layout state_layout() const {
        auto layout = detail::sized<rom_state_layout>();
        check(rom_model_state_layout(get(), &layout));
        return layout;
    }
    const rom_model *get() const noexcept { return model_.get(); }

private:
    explicit Model(rom_model *model) : model_(model, detail::Free()) {}
    std::shared_ptr<rom_model> model_;
};

class Loads {
public:
    // Wrenches on points, zero at first, and no others: about a loaded equilibrium not those in balance there either.
    Loads(const Model &model, const std::vector<std::size_t> &points)
        : Loads(model, static_cast<const char *>(nullptr), points) {}
    Loads(const Model &model, std::initializer_list<std::size_t> points)
        : Loads(model, std::vector<std::size_t>(points)) {}
    // A load case, and wrenches on points besides; an empty name stands for the loads of the equilibrium alone, NULL for none at all.
    Loads(const Model &model, const std::string &load_case, const std::vector<std::size_t> &points = {})
        : Loads(model, load_case.c_str(), points) {}
    Loads(const Model &model, const char *load_case, const std::vector<std::size_t> &points = {}) {
        rom_loads *loads = nullptr;
        check(rom_loads_new(model.get(), load_case, points.data(), points.size(), &loads));
        loads_.reset(loads);
    }
    // The same with blocks of stations besides the points; without a load case for NULL.
    static Loads with_stations(const Model &model, const char *load_case, const std::vector<std::size_t> &points,
                               const std::vector<std::size_t> &blocks) {
        rom_loads *loads = nullptr;
        check(rom_loads_new_with_stations(model.get(), load_case, points.data(), points.size(), blocks.data(),
                                          blocks.size(), &loads));
        return Loads(loads);
    }

    // Force and moment on every station of a block: 6 numbers each.
    void set_stations(std::size_t slot, rom_frame frame, const std::vector<double> &wrenches) {
        check(rom_loads_set_stations(loads_.get(), slot, frame, wrenches.data(), wrenches.size() / 6));
    }
    void clear() { check(rom_loads_clear(loads_.get())); }
    /// On the origin of A.
    void add_wrench(rom_frame frame, const Vector &force, const Vector &moment = Vector{}) {
        check(rom_loads_add_wrench(loads_.get(), frame, force.data(), moment.data()));
    }
    /// Generalised forces on the elastic modes.
    void add_modal(const std::vector<double> &forces) {
        check(rom_loads_add_modal(loads_.get(), forces.data(), forces.size()));
    }
    void add(std::size_t slot, rom_frame frame, const Vector &force, const Vector &moment = Vector{}) {
        check(rom_loads_add(loads_.get(), slot, frame, force.data(), moment.data()));
    }
    // In axes that turn with a section: Model::section_axes.
    void add_in_section(std::size_t slot, const std::array<double, 9> &axes, const Vector &force,
                        const Vector &moment = Vector{}) {
        check(rom_loads_add_in_section(loads_.get(), slot, axes.data(), force.data(), moment.data()));
    }
    const rom_loads *get() const noexcept { return loads_.get(); }

private:
    explicit Loads(rom_loads *loads) : loads_(loads) {}
    detail::Handle<rom_loads> loads_;
};

// At rest, A on G.
inline rom_motion motion() {
    auto motion = detail::sized<rom_motion>();
    motion.attitude[0] = 1.0;
    return motion;
}

inline rom_settings settings() {
    auto settings = detail::sized<rom_settings>();
    check(rom_settings_init(&settings));
    return settings;
}

class Simulation {
public:
    explicit Simulation(const Model &model, const rom_settings &given = settings())
        : state_size_(model.state_layout().size), n_sections_(model.n_sections()) {
        rom_simulation *simulation = nullptr;
        check(rom_simulation_new(model.get(), &given, &simulation));
        simulation_.reset(simulation);
    }
    // Where a load case starts.
    void start(const std::string &load_case) { check(rom_simulation_start(simulation_.get(), load_case.c_str())); }
    // Acceleration of free fall in G, from the next step on.
    void set_gravity(const Vector &acceleration) {
        check(rom_simulation_set_gravity(simulation_.get(), acceleration.data()));
    }
    void step(const Loads &loads) { check(rom_simulation_step(simulation_.get(), loads.get())); }
    void run(const Loads &loads, std::uint64_t n) { check(rom_simulation_run(simulation_.get(), loads.get(), n)); }
    // The host moves frame A: see rom_motion.
    void prescribe(const Loads &loads, const rom_motion &motion) {
        check(rom_simulation_prescribe(simulation_.get(), loads.get(), &motion));
    }
    void step_prescribed(const Loads &loads, const rom_motion &motion) {
        check(rom_simulation_step_prescribed(simulation_.get(), loads.get(), &motion));
    }
    void watch_errors(std::uint32_t every) { check(rom_simulation_watch_errors(simulation_.get(), every)); }
    rom_error_estimate error_estimate() const {
        auto estimate = detail::sized<rom_error_estimate>();
        check(rom_simulation_error_estimate(simulation_.get(), &estimate));
        return estimate;
    }
    rom_reaction reaction() const {
        auto reaction = detail::sized<rom_reaction>();
        check(rom_simulation_reaction(simulation_.get(), &reaction));
        return reaction;
    }
    rom_rigid rigid() const {
        auto rigid = detail::sized<rom_rigid>();
        check(rom_simulation_rigid(simulation_.get(), &rigid));
        return rigid;
    }
    rom_point point(std::size_t number) const {
        auto point = detail::sized<rom_point>();
        check(rom_simulation_point(simulation_.get(), number, &point));
        return point;
    }
    // Attitude, velocities and accelerations of a point; where they are not known they are solved under the loads.
    rom_point_motion point_motion(std::size_t number, const Loads &loads) {
        auto motion = detail::sized<rom_point_motion>();
        check(rom_simulation_point_motion(simulation_.get(), loads.get(), number, &motion));
        return motion;
    }
    rom_sensor_reading sensor(std::size_t number, const Loads &loads) {
        auto reading = detail::sized<rom_sensor_reading>();
        check(rom_simulation_sensor(simulation_.get(), loads.get(), number, &reading));
        return reading;
    }
    // Force and moment at every place of internal loads: 6 numbers each.
    std::vector<double> section_forces(const Loads &loads) {
        std::vector<double> forces(6 * n_sections_);
        check(rom_simulation_section_forces(simulation_.get(), loads.get(), forces.data(), forces.size()));
        return forces;
    }
    const rom_simulation *get() const noexcept { return simulation_.get(); }
    rom_ledger ledger() const {
        auto ledger = detail::sized<rom_ledger>();
        check(rom_simulation_ledger(simulation_.get(), &ledger));
        return ledger;
    }
    // A snapshot, as laid out by Model::state_layout.
    std::vector<double> state() const {
        std::vector<double> state(state_size_);
        check(rom_simulation_get_state(simulation_.get(), state.data(), state.size()));
        return state;
    }
    void restore(const std::vector<double> &state) {
        check(rom_simulation_set_state(simulation_.get(), state.data(), state.size()));
    }

private:
    detail::Handle<rom_simulation> simulation_;
    std::size_t state_size_, n_sections_;
};

// A block of stations: where they are and how they move, station after station, after every read().
class Stations {
public:
    Stations(const Model &model, std::size_t block) {
        rom_stations *stations = nullptr;
        check(rom_stations_new(model.get(), block, &stations));
        stations_.reset(stations);
        const std::size_t n = size();
        position.resize(3 * n);
        attitude.resize(4 * n);
        velocity.resize(3 * n);
        angular_velocity.resize(3 * n);
    }
    std::size_t size() const noexcept { return rom_stations_count(stations_.get()); }
    void read(const Simulation &simulation, rom_station_axes axes) {
        check(rom_stations_read(stations_.get(), simulation.get(), axes, size(), position.data(), attitude.data(),
                                velocity.data(), angular_velocity.data()));
    }
    std::vector<double> position, attitude, velocity, angular_velocity;

private:
    detail::Handle<rom_stations> stations_;
};

// The equations of motion, for hosts that integrate on their own.
class Evaluator {
public:
    explicit Evaluator(const Model &model) : n_(rom_model_n_variables(model.get())) {
        rom_evaluator *evaluator = nullptr;
        check(rom_evaluator_new(model.get(), &evaluator));
        evaluator_.reset(evaluator);
    }
    std::size_t n_variables() const noexcept { return n_; }
    // Both of n_variables() numbers; they may be the same.
    void derivatives(double t, const double *y, const Loads &loads, double *y_dot) {
        check(rom_evaluator_derivatives(evaluator_.get(), t, y, n_, loads.get(), y_dot));
    }
    // q, q_dot, beta_star, a small turn of A about its own axes, position: one less than the variables.
    std::size_t n_tangent() const noexcept { return n_ - 1; }
    // Derivative of the rates of the tangent coordinates by themselves, row by row: n_tangent() squared numbers.
    void jacobian(double t, const double *y, const Loads &loads, double *matrix) {
        check(rom_evaluator_jacobian(evaluator_.get(), t, y, n_, loads.get(), matrix, n_tangent() * n_tangent()));
    }
    // By a factor on the loads, at the place of the last jacobian(): n_tangent() numbers.
    void by_load(const Loads &loads, double *column) {
        check(rom_evaluator_by_load(evaluator_.get(), loads.get(), column, n_tangent()));
    }

private:
    detail::Handle<rom_evaluator> evaluator_;
    std::size_t n_;
};

} // namespace rom

#endif
