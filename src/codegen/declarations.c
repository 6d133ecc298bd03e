
/* Everything that changes from step to step. */
typedef struct rom_state {
    rom_real time;                     /* s */
    rom_real time_carry;               /* what rounding has taken from the time, s */
    rom_real q[ROM_MODES_OR_ONE];      /* modal amplitudes */
    rom_real q_dot[ROM_MODES_OR_ONE];  /* 1/s */
    rom_real beta_star[6];             /* rigid part of the velocity of A, in A: beta = Phi_R q_dot + beta*, m/s, rad/s */
    rom_real attitude[4];              /* of A */
    rom_real position[3];              /* of the origin of A in G, m (of the centre of mass in the method mean-axes) */
} rom_state;

/* Force (N) and moment (N m) by the axes of their components: G, A, and those of the node, which turn with it. */
typedef struct rom_wrench {
    rom_real dead_force[3], dead_moment[3];
    rom_real body_force[3], body_moment[3];
    rom_real node_force[3], node_moment[3];
} rom_wrench;

/* What a host applies, besides the load case. */
typedef struct rom_loads {
    rom_wrench point[ROM_POINTS_OR_ONE]; /* on the named points */
    rom_wrench frame_a;                  /* on the origin of A */
    rom_real modal[ROM_MODES_OR_ONE];    /* generalised forces on the modes */
} rom_loads;

/* Time derivative of a state. */
typedef struct rom_rate {
    rom_real q_dot[ROM_MODES_OR_ONE], q_ddot[ROM_MODES_OR_ONE], beta_star_dot[6], attitude_dot[4], position_dot[3];
} rom_rate;

/* Motion of A: position, velocity and angular velocity with components in A and in G. */
typedef struct rom_rigid {
    rom_real r_g[3], v_a[3], w_a[3], v_g[3], w_g[3], attitude[4];
} rom_rigid;

/* A named point: displacement from the equilibrium in A, position in G, m. */
typedef struct rom_point {
    rom_real dr_a[3], r_g[3];
} rom_point;

/* How a named point moves, seen from G; the attitude is that of the axes of its node. */
typedef struct rom_motion {
    rom_real attitude[4], v_g[3], w_g[3], a_g[3], alpha_g[3];
} rom_motion;

/* What a sensor reads in its own axes: acceleration (less that of free fall where it feels gravity), spin and its rate. */
typedef struct rom_reading {
    rom_real a[3], w[3], alpha[3];
} rom_reading;

/* The state at t = 0: at rest in the equilibrium. */
void rom_init(rom_state *state);

/* One step of ROM_DT; loads may be NULL. 0, or -1 when the result is not finite: the state is then the one before. */
int rom_step(rom_state *state, const rom_loads *loads);

/* The equations of motion, for hosts that integrate themselves; loads may be NULL. */
void rom_derivatives(const rom_state *state, const rom_loads *loads, rom_rate *rate);

void rom_rigid_output(const rom_state *state, rom_rigid *out);

#if ROM_POINTS > 0
/* 0, or -1 when there is no such point; the rate is that of the state. */
int rom_point_output(const rom_state *state, int point, rom_point *out);
int rom_point_motion(const rom_state *state, const rom_rate *rate, int point, rom_motion *out);
#endif

#if ROM_SENSORS > 0
int rom_sensor_output(const rom_state *state, const rom_rate *rate, int sensor, rom_reading *out);
#endif

#if ROM_SECTIONS > 0
/* Force (N) and moment (N m) on the positive face of a section, in the axes of the deformed section; the rate is that of the state under
   these loads. */
int rom_section_output(const rom_state *state, const rom_loads *loads, const rom_rate *rate, int section, rom_real out[6]);
#endif
