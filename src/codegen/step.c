/* ---- The equations of motion and the step. ---- */

/* beta = Phi_R q_dot + beta*: true velocity of A, components in A. */
static void true_velocity(const rom_real *u, rom_real beta[6])
{
    int r;
    for (r = 0; r < 6; r++)
        beta[r] = u[ROM_MODES + r];
    add_combined(PHI_R, u, beta);
}

/* c_ilr u_l beta_r + k_ilrs q_l beta_r beta_s: products of the state, then one sparse matrix by rows. */
static void gyroscopic_forces(const rom_real *q, const rom_real *u, const rom_real beta[6], rom_real *out)
{
    rom_real products[ROM_N_PRODUCTS];
    int i, l, r, s, at = 0;
    long e;
    for (l = 0; l < ROM_MODES + 6; l++)
        for (r = 0; r < 6; r++)
            products[at++] = u[l] * beta[r];
    for (l = 0; l < ROM_MODES; l++)
        for (r = 0; r < 6; r++)
            for (s = r; s < 6; s++)
                products[at++] = q[l] * (beta[r] * beta[s]);
    for (i = 0; i < ROM_MODES + 6; i++) {
        rom_real sum = R(0.0);
        for (e = ROW[i]; e < ROW[i + 1]; e++)
            sum += VALUE[e] * products[COLUMN[e]];
        out[i] = sum;
    }
}

/* Adds a wrench on a node: to the elastic rows by its shapes, to the resultant about the origin with the lever arm. */
static void add_wrench(const rom_wrench *wrench, const rom_real attitude[9], const rom_real turn[9],
                       const rom_real tangential[9], const rom_real position[3], const rom_real arm[3],
                       rom_real nodal[6], rom_real resultant[6])
{
    rom_real f[3], m[3], x[3], moment[3];
    int k;
    mul_t(attitude, wrench->dead_force, f);
    mul_t(attitude, wrench->dead_moment, m);
    mul(turn, wrench->node_force, x);
    for (k = 0; k < 3; k++)
        f[k] += wrench->body_force[k] + x[k];
    mul(turn, wrench->node_moment, x);
    for (k = 0; k < 3; k++)
        m[k] += wrench->body_moment[k] + x[k];
    cross(position, f, x);
    for (k = 0; k < 3; k++) {
        resultant[k] += f[k];
        resultant[3 + k] += m[k] + x[k];
    }
    cross(arm, f, x);
    for (k = 0; k < 3; k++)
        m[k] += x[k];
    mul_t(turn, m, x);
    mul_t(tangential, x, moment);
    for (k = 0; k < 3; k++) {
        nodal[k] = f[k];
        nodal[3 + k] = moment[k];
    }
}

/* Position of a node and of the point on it in the model's axes, and the rotation of the node. */
static void deform(const point_table *point, const rom_real phi[][6], const rom_real *q, rom_real position[3],
                   rom_real arm[3], rom_real turn[9], rom_real tangential[9])
{
    rom_real moved[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) }, relative[9];
    int k;
    add_combined(phi, q, moved);
    rotation(&moved[3], relative, tangential);
    mat_mul(point->rotation, relative, turn);
    mul(turn, point->offset, arm);
    for (k = 0; k < 3; k++)
        position[k] = point->position[k] + moved[k] + arm[k];
}

/* What acts on every point, and on the stations of distributed loads. */
static void gather_wrenches(rom_real t, const rom_real beta[6], const rom_real r_g[3], const rom_loads *loads,
                            rom_wrench *wrench)
{
    static const rom_wrench NONE;
    int p;
    for (p = 0; p < ROM_CARRIERS_OR_ONE; p++)
        wrench[p] = loads && p < ROM_POINTS ? loads->point[p] : NONE;
    load_case(t, &beta[0], &beta[3], r_g, wrench);
}

static void external_forces(rom_real t, const rom_real *q, const rom_real beta[6], const rom_real attitude[9],
                            const rom_real r_g[3], const rom_loads *loads, rom_real *out)
{
    rom_wrench wrench[ROM_CARRIERS_OR_ONE];
    rom_real resultant[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) };
    int i, k;
    for (i = 0; i < ROM_MODES; i++)
        out[i] = loads ? loads->modal[i] : R(0.0);
    gather_wrenches(t, beta, r_g, loads, wrench);
#if ROM_CARRIERS > 0
    int p;
    for (p = 0; p < ROM_CARRIERS; p++) {
        rom_real position[3], arm[3], turn[9], tangential[9], nodal[6];
        deform(&POINT[p], POINT_PHI[p], q, position, arm, turn, tangential);
        add_wrench(&wrench[p], attitude, turn, tangential, position, arm, nodal, resultant);
        for (i = 0; i < ROM_MODES; i++)
            for (k = 0; k < 6; k++)
                out[i] += POINT_PHI[p][i][k] * nodal[k];
    }
#else
    (void)POINT;
    (void)POINT_PHI;
#endif
    if (loads) {
        /* The wrench on A: its work in the modes comes by Phi_R of the resultant, in mean axes by the motion of A in them. */
        rom_real position[3], arm[3], turn[9], tangential[9], nodal[6];
        deform(&FRAME_A, FRAME_A_PHI, q, position, arm, turn, tangential);
        add_wrench(&loads->frame_a, attitude, turn, tangential, position, arm, nodal, resultant);
        for (i = 0; i < ROM_MODES; i++)
            for (k = 0; k < 6; k++)
                out[i] += FRAME_A_PHI[i][k] * nodal[k];
    }
    for (i = 0; i < ROM_MODES; i++)
        for (k = 0; k < 6; k++)
            out[i] += PHI_R[i][k] * resultant[k];
    for (k = 0; k < 6; k++)
        out[ROM_MODES + k] = resultant[k];
}

#if ROM_HAS_GRAVITY
/* Weight: first moment of mass m c_0 + S_j q_j + 1/2 H_jk q_j q_k in the field g_A. */
static void add_weight(const rom_real attitude[9], const rom_real *q, rom_real *out)
{
    rom_real g[3], moved[3] = { R(0.0), R(0.0), R(0.0) }, moment[3], fixed[3];
    int i, k;
    mul_t(attitude, GRAVITY, g);
    for (i = 0; i < ROM_MODES; i++) {
        rom_real bend[3] = { R(0.0), R(0.0), R(0.0) };
#if ROM_HAS_SECOND_MOMENT
        int j;
        for (j = 0; j < ROM_MODES; j++)
            for (k = 0; k < 3; k++)
                bend[k] += q[j] * SECOND_MOMENT[i][j][k];
#endif
        for (k = 0; k < 3; k++) {
            out[i] += g[k] * (MOMENTUM[i][k] + bend[k]);
            moved[k] += q[i] * (FIRST_MOMENT[i][k] + R(0.5) * bend[k]);
        }
    }
    cross(moved, g, moment);
#if ROM_MODES > 0
    for (i = 0; i < ROM_MODES; i++)
        out[i] += dot(&PHI_R[i][3], moment);
#endif
    cross(MASS_CENTRE, g, fixed);
    for (k = 0; k < 3; k++) {
        out[ROM_MODES + k] += MASS * g[k];
        out[ROM_MODES + 3 + k] += moment[k] + fixed[k];
    }
}
#endif

/* Slope of y = (q, q_dot, beta*, zeta, r_G). */
static void slope(rom_real t, const rom_real *y, const rom_loads *loads, rom_real *dy)
{
    const rom_real *q = y, *u = y + ROM_MODES, *zeta = y + 2 * ROM_MODES + 6, *r_g = zeta + 4;
    rom_real *u_dot = dy + ROM_MODES, *zeta_dot = dy + 2 * ROM_MODES + 6;
    rom_real beta[6], attitude[9], gyroscopic[ROM_MODES + 6], external[ROM_MODES + 6], turn[4];
    int i, k;
    true_velocity(u, beta);
    attitude_matrix(zeta, attitude);
    gyroscopic_forces(q, u, beta, gyroscopic);
    external_forces(t, q, beta, attitude, r_g, loads, external);
#if ROM_HAS_COUPLED_DAMPING
    for (i = 0; i < ROM_MODES; i++)
        for (k = 0; k < ROM_MODES; k++)
            gyroscopic[i] += COUPLED_DAMPING[i][k] * u[k];
#endif
#if ROM_HAS_GRAVITY
    add_weight(attitude, q, external);
#endif
#if ROM_HAS_TRIM
    for (i = 0; i < ROM_MODES; i++)
        external[i] -= ELASTIC_FORCE[i];
#endif
    for (i = 0; i < ROM_MODES; i++) {
        dy[i] = u[i];
        u_dot[i] = (external[i] - gyroscopic[i] - DAMPING[i] * u[i] - STIFFNESS[i] * q[i]) * INVERSE_MASS[i];
    }
    for (i = 0; i < 6; i++) {
        rom_real sum = R(0.0);
        for (k = 0; k < 6; k++)
            sum += RIGID_MASS_INVERSE[i][k] * (external[ROM_MODES + k] - gyroscopic[ROM_MODES + k]);
        u_dot[ROM_MODES + i] = sum;
    }
    turn[0] = R(0.0);
    for (k = 0; k < 3; k++)
        turn[k + 1] = R(0.5) * beta[3 + k];
    quaternion_product(zeta, turn, zeta_dot);
    mul(attitude, beta, zeta_dot + 4);
}

static void pack(const rom_state *state, rom_real *y)
{
    int i;
    for (i = 0; i < ROM_MODES; i++) {
        y[i] = state->q[i];
        y[ROM_MODES + i] = state->q_dot[i];
    }
    for (i = 0; i < 6; i++)
        y[2 * ROM_MODES + i] = state->beta_star[i];
    for (i = 0; i < 4; i++)
        y[2 * ROM_MODES + 6 + i] = state->attitude[i];
    for (i = 0; i < 3; i++)
        y[2 * ROM_MODES + 10 + i] = state->position[i];
}

void rom_init(rom_state *state)
{
    static const rom_state START = ROM_START;
    *state = START;
}

int rom_step(rom_state *state, const rom_loads *loads)
{
    rom_real start[ROM_SIZE], stage[ROM_SIZE], rate[ROM_SIZE], sum[ROM_SIZE], check = R(0.0), norm, time, increment;
    const rom_real fraction[4] = { R(0.0), R(0.5), R(0.5), R(1.0) }, weight[4] = { R(1.0), R(2.0), R(2.0), R(1.0) };
    rom_state next = *state;
    rom_real instant[4];
    int i, s;
    /* Compensated, so that the time does not drift. */
    increment = ROM_DT + state->time_carry;
    time = state->time + increment;
    next.time_carry = increment - (time - state->time);
    next.time = time;
    instant[0] = state->time;
    instant[1] = instant[2] = state->time + R(0.5) * ROM_DT;
    instant[3] = next.time;

    pack(state, start);
    for (i = 0; i < ROM_SIZE; i++)
        sum[i] = rate[i] = R(0.0);
    for (s = 0; s < 4; s++) {
        for (i = 0; i < ROM_SIZE; i++)
            stage[i] = start[i] + fraction[s] * ROM_DT * rate[i];
        slope(instant[s], stage, loads, rate);
        for (i = 0; i < ROM_SIZE; i++)
            sum[i] += weight[s] * rate[i];
    }
    for (i = 0; i < ROM_SIZE; i++) {
        start[i] += ROM_DT / R(6.0) * sum[i];
        /* Zero for finite numbers only. */
        check += start[i] * R(0.0);
    }
    if (!(check >= R(0.0)))
        return -1;
    for (i = 0; i < ROM_MODES; i++) {
        next.q[i] = start[i];
        next.q_dot[i] = start[ROM_MODES + i];
    }
    for (i = 0; i < 6; i++)
        next.beta_star[i] = start[2 * ROM_MODES + i];
    norm = R(0.0);
    for (i = 0; i < 4; i++)
        norm += start[2 * ROM_MODES + 6 + i] * start[2 * ROM_MODES + 6 + i];
    norm = R(1.0) / rom_sqrt(norm);
    for (i = 0; i < 4; i++)
        next.attitude[i] = norm * start[2 * ROM_MODES + 6 + i];
    for (i = 0; i < 3; i++)
        next.position[i] = start[2 * ROM_MODES + 10 + i];
    *state = next;
    return 0;
}

void rom_derivatives(const rom_state *state, const rom_loads *loads, rom_rate *rate)
{
    rom_real y[ROM_SIZE], dy[ROM_SIZE];
    int i;
    pack(state, y);
    slope(state->time, y, loads, dy);
    for (i = 0; i < ROM_MODES; i++) {
        rate->q_dot[i] = dy[i];
        rate->q_ddot[i] = dy[ROM_MODES + i];
    }
    for (i = 0; i < 6; i++)
        rate->beta_star_dot[i] = dy[2 * ROM_MODES + i];
    for (i = 0; i < 4; i++)
        rate->attitude_dot[i] = dy[2 * ROM_MODES + 6 + i];
    for (i = 0; i < 3; i++)
        rate->position_dot[i] = dy[2 * ROM_MODES + 10 + i];
}

void rom_rigid_output(const rom_state *state, rom_rigid *out)
{
    rom_real y[ROM_SIZE], beta[6], attitude[9];
    int k;
    pack(state, y);
    true_velocity(y + ROM_MODES, beta);
    attitude_matrix(state->attitude, attitude);
#if ROM_MEAN_AXES
    {
        /* The state is about the centre of mass; A sits on the reference node, which moves in the modes. */
        rom_real origin[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) }, whirl[3], shift[3];
        rom_real rate[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) };
        add_combined(FRAME_A_PHI, state->q, origin);
        add_combined(FRAME_A_PHI, state->q_dot, rate);
        for (k = 0; k < 3; k++)
            origin[k] += FRAME_A.position[k];
        cross(&beta[3], origin, whirl);
        mul(attitude, origin, shift);
        for (k = 0; k < 3; k++) {
            beta[k] += whirl[k] + rate[k];
            out->r_g[k] = state->position[k] + shift[k];
        }
    }
#else
    for (k = 0; k < 3; k++)
        out->r_g[k] = state->position[k];
#endif
    for (k = 0; k < 3; k++) {
        out->v_a[k] = beta[k];
        out->w_a[k] = beta[3 + k];
    }
    mul(attitude, out->v_a, out->v_g);
    mul(attitude, out->w_a, out->w_g);
    for (k = 0; k < 4; k++)
        out->attitude[k] = state->attitude[k];
}

#if ROM_POINTS > 0
/* Displacement of a point in given shapes, without the difference of two positions. */
static void displacement(const point_table *point, const rom_real phi[][6], const rom_real *q, rom_real out[3])
{
    rom_real moved[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) };
    rom_real turn[9], tangential[9], arm[3], turned[3];
    int k;
    add_combined(phi, q, moved);
    rotation(&moved[3], turn, tangential);
    for (k = 0; k < 3; k++)
        turn[4 * k] -= R(1.0);
    mul(turn, point->offset, arm);
    mul(point->rotation, arm, turned);
    for (k = 0; k < 3; k++)
        out[k] = moved[k] + turned[k];
}

int rom_point_output(const rom_state *state, int point, rom_point *out)
{
    rom_real attitude[9], r_a[3], moved[3], arm[3];
    int k;
    if (point < 0 || point >= ROM_POINTS)
        return -1;
    displacement(&POINT[point], POINT_SHAPE[point], state->q, out->dr_a);
    displacement(&POINT[point], POINT_PHI[point], state->q, moved);
    mul(POINT[point].rotation, POINT[point].offset, arm);
    for (k = 0; k < 3; k++)
        r_a[k] = POINT[point].position[k] + arm[k] + moved[k];
    attitude_matrix(state->attitude, attitude);
    mul(attitude, r_a, out->r_g);
    for (k = 0; k < 3; k++)
        out->r_g[k] += state->position[k];
    return 0;
}
#endif
