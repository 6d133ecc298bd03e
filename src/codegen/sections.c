
#if ROM_SECTIONS > 0
/* Sum of a row of a table against a vector. */
static rom_real row_dot(const rom_real *row, const rom_real *x, int n)
{
    rom_real sum = R(0.0);
    int i;
    for (i = 0; i < n; i++)
        sum += row[i] * x[i];
    return sum;
}

int rom_section_output(const rom_state *state, const rom_loads *loads, const rom_rate *rate, int section,
                       rom_real out[6])
{
    int a;
#if ROM_SUMS_FORCES
    rom_wrench wrench[ROM_CARRIERS_OR_ONE];
    rom_real y[ROM_SIZE], u_dot[ROM_MODES + 6], beta[6], attitude[9], pair[21], g[3] = { R(0.0), R(0.0), R(0.0) };
    rom_real nodal[6 * ROM_CARRIERS_OR_ONE];
    const rom_real *u;
    int i, k, at = 0;
    if (section < 0 || section >= ROM_SECTIONS)
        return -1;
    pack(state, y);
    u = y + ROM_MODES;
    true_velocity(u, beta);
    attitude_matrix(state->attitude, attitude);
    gather_wrenches(state->time, beta, state->position, loads, wrench);
    for (i = 0; i < 6 * ROM_CARRIERS_OR_ONE; i++)
        nodal[i] = R(0.0);
    for (i = 0; i < ROM_CARRIERS; i++) {
        rom_real position[3], arm[3], turn[9], tangential[9], resultant[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) };
        deform(&POINT[i], POINT_PHI[i], state->q, position, arm, turn, tangential);
        add_wrench(&wrench[i], attitude, turn, tangential, position, arm, &nodal[6 * i], resultant);
    }
    for (i = 0; i < ROM_MODES; i++)
        u_dot[i] = rate->q_ddot[i];
    for (i = 0; i < 6; i++) {
        u_dot[ROM_MODES + i] = rate->beta_star_dot[i];
        for (k = i; k < 6; k++)
            pair[at++] = beta[i] * beta[k];
    }
#if ROM_HAS_GRAVITY
    mul_t(attitude, GRAVITY, g);
#endif
    for (a = 0; a < 6; a++) {
        const int row = 6 * section + a;
        /* Inertia forces, damping; weight as an acceleration of the whole. */
        rom_real sum = SECTION_REST[row][0] - row_dot(SECTION_INERTIA[row], u_dot, ROM_MODES + 6);
        sum += row_dot(&SECTION_INERTIA[row][ROM_MODES], g, 3);
        sum -= row_dot(SECTION_DAMPING[row], state->q_dot, ROM_MODES);
        for (i = 0; i < ROM_MODES + 6; i++)
            sum -= row_dot(&SECTION_C[row][6 * i], beta, 6) * u[i];
        for (i = 0; i < ROM_MODES; i++) {
            sum -= row_dot(&SECTION_K[row][21 * i], pair, 21) * state->q[i];
            sum += row_dot(&SECTION_WEIGHT[row][3 * i], g, 3) * state->q[i];
        }
        if (loads)
            sum += row_dot(SECTION_INERTIA[row], loads->modal, ROM_MODES);
        out[a] = sum + row_dot(SECTION_PLACE[row], nodal, 6 * ROM_CARRIERS);
    }
#else
    (void)loads;
    (void)rate;
    if (section < 0 || section >= ROM_SECTIONS)
        return -1;
    for (a = 0; a < 6; a++) {
        const int row = 6 * section + a;
        out[a] = SECTION_REST[row][0] + row_dot(SECTION_MODAL[row], state->q, ROM_MODES)
               + row_dot(SECTION_MODAL_RATE[row], state->q_dot, ROM_MODES);
    }
#endif
    return 0;
}
#endif
