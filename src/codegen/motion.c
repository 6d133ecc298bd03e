
#if ROM_POINTS > 0
/* T_dot theta_dot: what the spin T theta_dot gains at constant theta_dot. */
static void tangential_rate(const rom_real theta[3], const rom_real theta_dot[3], rom_real out[3])
{
    rom_real scalar[5], turned[3], twice[3], other[3];
    const rom_real t2_dot = R(2.0) * dot(theta, theta_dot);
    int k;
    rotation_scalars(dot(theta, theta), scalar);
    cross(theta, theta_dot, turned);
    cross(theta, turned, twice);
    cross(theta_dot, turned, other);
    for (k = 0; k < 3; k++)
        out[k] = scalar[4] * t2_dot * twice[k] + scalar[2] * other[k] - scalar[3] * t2_dot * turned[k];
}

int rom_point_motion(const rom_state *state, const rom_rate *rate, int point, rom_motion *out)
{
    rom_real y[ROM_SIZE], u_dot[ROM_MODES + 6], beta[6], beta_dot[6], to_g[9], turn[9], tangential[9];
    rom_real moved[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) };
    rom_real moved_dot[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) };
    rom_real moved_ddot[6] = { R(0.0), R(0.0), R(0.0), R(0.0), R(0.0), R(0.0) };
    rom_real r[3], arm[3], r_dot[3], r_ddot[3], spin[3], spin_rate[3], spin_a[3], spin_rate_a[3];
    rom_real whirl[3], x[3], z[3], velocity[3], half[4], relative[4], node[4], scalar[5];
    const rom_real *v = beta, *w = &beta[3];
    int i, k;
    if (point < 0 || point >= ROM_POINTS)
        return -1;
    pack(state, y);
    true_velocity(y + ROM_MODES, beta);
    for (i = 0; i < ROM_MODES; i++)
        u_dot[i] = rate->q_ddot[i];
    for (i = 0; i < 6; i++)
        u_dot[ROM_MODES + i] = rate->beta_star_dot[i];
    true_velocity(u_dot, beta_dot);
    attitude_matrix(state->attitude, to_g);
    add_combined(POINT_PHI[point], state->q, moved);
    add_combined(POINT_PHI[point], state->q_dot, moved_dot);
    add_combined(POINT_PHI[point], rate->q_ddot, moved_ddot);
    deform(&POINT[point], POINT_PHI[point], state->q, r, arm, turn, tangential);

    /* Spin of the node relative to A and its rate, in its own axes, then in A. */
    mul(tangential, &moved_dot[3], spin);
    mul(tangential, &moved_ddot[3], spin_rate);
    tangential_rate(&moved[3], &moved_dot[3], x);
    for (k = 0; k < 3; k++)
        spin_rate[k] += x[k];
    mul(turn, spin, spin_a);
    mul(turn, spin_rate, spin_rate_a);
    cross(spin, POINT[point].offset, whirl);
    mul(turn, whirl, x);
    for (k = 0; k < 3; k++)
        r_dot[k] = moved_dot[k] + x[k];
    cross(spin_rate, POINT[point].offset, x);
    cross(spin, whirl, z);
    for (k = 0; k < 3; k++)
        x[k] += z[k];
    mul(turn, x, z);
    for (k = 0; k < 3; k++)
        r_ddot[k] = moved_ddot[k] + z[k];

    cross(w, r, x);
    for (k = 0; k < 3; k++)
        velocity[k] = v[k] + x[k] + r_dot[k];
    mul(to_g, velocity, out->v_g);
    /* a = v_dot + w_dot x r + w x (velocity + r_dot) + r_ddot */
    cross(&beta_dot[3], r, z);
    for (k = 0; k < 3; k++)
        r_ddot[k] += beta_dot[k] + z[k];
    for (k = 0; k < 3; k++)
        velocity[k] += r_dot[k];
    cross(w, velocity, x);
    for (k = 0; k < 3; k++)
        r_ddot[k] += x[k];
    mul(to_g, r_ddot, out->a_g);
    cross(w, spin_a, x);
    for (k = 0; k < 3; k++) {
        spin_rate_a[k] += beta_dot[3 + k] + x[k];
        spin_a[k] += w[k];
    }
    mul(to_g, spin_a, out->w_g);
    mul(to_g, spin_rate_a, out->alpha_g);

    /* Unit quaternion of the rotation vector. */
    for (k = 0; k < 3; k++)
        x[k] = R(0.5) * moved[3 + k];
    rotation_scalars(dot(x, x), scalar);
    half[0] = R(1.0) - dot(x, x) * scalar[1];
    for (k = 0; k < 3; k++)
        half[k + 1] = scalar[0] * x[k];
    quaternion_product(POINT[point].quaternion, half, relative);
    quaternion_product(state->attitude, relative, node);
    for (k = 0; k < 4; k++)
        out->attitude[k] = node[k];
    return 0;
}
#endif

#if ROM_SENSORS > 0
int rom_sensor_output(const rom_state *state, const rom_rate *rate, int sensor, rom_reading *out)
{
    rom_motion motion;
    rom_real node[9], x[3], felt[3];
    int k;
    if (sensor < 0 || sensor >= ROM_SENSORS)
        return -1;
    rom_point_motion(state, rate, SENSOR[sensor].point, &motion);
    attitude_matrix(motion.attitude, node);
    for (k = 0; k < 3; k++)
        felt[k] = motion.a_g[k] - SENSOR[sensor].gravity[k];
    mul_t(node, felt, x);
    mul_t(SENSOR[sensor].axes, x, out->a);
    mul_t(node, motion.w_g, x);
    mul_t(SENSOR[sensor].axes, x, out->w);
    mul_t(node, motion.alpha_g, x);
    mul_t(SENSOR[sensor].axes, x, out->alpha);
    return 0;
}
#endif
