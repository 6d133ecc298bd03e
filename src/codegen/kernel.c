/* ---- Small algebra: matrices are row-major, quaternions scalar first. ---- */

static void cross(const rom_real a[3], const rom_real b[3], rom_real out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static rom_real dot(const rom_real a[3], const rom_real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* out = A b, and out = A^t b */
static void mul(const rom_real a[9], const rom_real b[3], rom_real out[3])
{
    int i;
    for (i = 0; i < 3; i++)
        out[i] = dot(&a[3 * i], b);
}

static void mul_t(const rom_real a[9], const rom_real b[3], rom_real out[3])
{
    int i;
    for (i = 0; i < 3; i++)
        out[i] = a[i] * b[0] + a[3 + i] * b[1] + a[6 + i] * b[2];
}

/* C^{GA} of a quaternion of any length. */
static void attitude_matrix(const rom_real z[4], rom_real c[9])
{
    const rom_real f = R(2.0) / (z[0] * z[0] + z[1] * z[1] + z[2] * z[2] + z[3] * z[3]);
    const rom_real fx = f * z[1], fy = f * z[2], fz = f * z[3];
    const rom_real xy = fx * z[2], xz = fx * z[3], yz = fy * z[3];
    const rom_real sx = z[0] * fx, sy = z[0] * fy, sz = z[0] * fz;
    const rom_real xx = fx * z[1], yy = fy * z[2], zz = fz * z[3];
    c[0] = R(1.0) - (yy + zz); c[1] = xy - sz; c[2] = xz + sy;
    c[3] = xy + sz; c[4] = R(1.0) - (xx + zz); c[5] = yz - sx;
    c[6] = xz - sy; c[7] = yz + sx; c[8] = R(1.0) - (xx + yy);
}

static void quaternion_product(const rom_real a[4], const rom_real b[4], rom_real out[4])
{
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

/* I + a theta~ + b theta~ theta~ */
static void quadratic(const rom_real t[3], rom_real a, rom_real b, rom_real out[9])
{
    const rom_real xy = b * t[0] * t[1], xz = b * t[0] * t[2], yz = b * t[1] * t[2];
    const rom_real xx = b * t[0] * t[0], yy = b * t[1] * t[1], zz = b * t[2] * t[2];
    out[0] = R(1.0) - (yy + zz); out[1] = xy - a * t[2]; out[2] = xz + a * t[1];
    out[3] = xy + a * t[2]; out[4] = R(1.0) - (xx + zz); out[5] = yz - a * t[0];
    out[6] = xz - a * t[1]; out[7] = yz + a * t[0]; out[8] = R(1.0) - (xx + yy);
}

/* sin t/t, c = (1 - cos t)/t^2, d = (t - sin t)/t^3 and the slopes of c and d over t^2: by series below one radian. */
static void rotation_scalars(rom_real t2, rom_real out[5])
{
    int k;
    for (k = 0; k < 5; k++)
        out[k] = R(0.0);
    if (t2 < R(1.0)) {
        /* (-1)^k t^2k / (2k+1)!, / (2k+2)!, / (2k+3)!; before holds the power of one order less. */
        rom_real term = R(1.0), before = R(0.0);
        for (k = 0; k < 10; k++) {
            const rom_real n = (rom_real)(2 * k), two = n + R(2.0), three = n + R(3.0);
            out[0] += term;
            out[1] += term / two;
            out[2] += term / (two * three);
            out[3] += (rom_real)k * before / two;
            out[4] += (rom_real)k * before / (two * three);
            before = -term / (two * three);
            term *= -t2 / (two * three);
        }
    } else {
        const rom_real t = rom_sqrt(t2), sine = rom_sin(t), half = rom_sin(R(0.5) * t);
        out[0] = sine / t;
        out[1] = R(2.0) * half * half / t2;
        out[2] = (t - sine) / (t2 * t);
        out[3] = R(0.5) * (out[0] - R(2.0) * out[1]) / t2;
        out[4] = R(0.5) * (out[1] - R(3.0) * out[2]) / t2;
    }
}

/* exp(theta~) and T(theta) = I - c theta~ + d theta~ theta~ */
static void rotation(const rom_real theta[3], rom_real turn[9], rom_real tangential[9])
{
    rom_real scalar[5];
    rotation_scalars(dot(theta, theta), scalar);
    quadratic(theta, scalar[0], scalar[1], turn);
    quadratic(theta, -scalar[1], scalar[2], tangential);
}

static void mat_mul(const rom_real a[9], const rom_real b[9], rom_real out[9])
{
    int i;
    for (i = 0; i < 3; i++)
        mul_t(b, &a[3 * i], &out[3 * i]);
}

/* Sum of six-vectors weighted by modal amplitudes, added to out. */
static void add_combined(const rom_real phi[][6], const rom_real *q, rom_real out[6])
{
    int i, r;
    for (i = 0; i < ROM_MODES; i++)
        for (r = 0; r < 6; r++)
            out[r] += phi[i][r] * q[i];
}

/* Instants are compared to within four units in the last place, so that a jump is seen by the step that ends on it. */
#if ROM_HAS_JUMPS
static int reached(rom_real t, rom_real instant)
{
    return t >= instant - R(4.0) * ROM_EPSILON * rom_fabs(instant);
}
#endif
