/* A flexible body in a loop: a load case of the model, and a force of our own on one point, set from what is known after
 * every step. Ends with a rewind: the same steps give the same bits.
 *
 *     cc loop.c $(pkg-config --cflags --libs rom) -o loop && ./loop fmb.rom lc2 P
 */
#include <rom.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(rom_status status)
{
    if (status != ROM_OK) {
        fprintf(stderr, "%s: %s\n", rom_status_text(status), rom_last_error());
        exit(1);
    }
}

/* One step under the load case and a damper between the point and inertial space. */
static void damped_step(rom_simulation *simulation, rom_loads *loads, size_t point)
{
    rom_point_motion now = { .struct_size = sizeof now };
    double force[3], none[3] = { 0.0, 0.0, 0.0 };
    int i;

    check(rom_simulation_point_motion(simulation, loads, point, &now));
    for (i = 0; i < 3; i++) {
        force[i] = -0.5 * now.v_g[i]; /* 0.5 N per m/s */
    }
    check(rom_loads_clear(loads));
    check(rom_loads_add(loads, 0, ROM_FRAME_DEAD, force, none));
    check(rom_simulation_step(simulation, loads));
}

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : "fmb.rom";
    const char *load_case = argc > 2 ? argv[2] : "lc2";
    const char *point_name = argc > 3 ? argv[3] : "P";
    rom_model *model;
    rom_simulation *simulation;
    rom_loads *loads;
    rom_settings settings = { .struct_size = sizeof settings };
    rom_load_case author = { .struct_size = sizeof author };
    rom_state_layout layout = { .struct_size = sizeof layout };
    rom_rigid rigid = { .struct_size = sizeof rigid };
    rom_point tip = { .struct_size = sizeof tip };
    double *snapshot, *first, *second;
    size_t point, steps, i;

    check(rom_model_read(path, &model));
    check(rom_model_find_point(model, point_name, &point));
    check(rom_model_load_case(model, load_case, &author));
    check(rom_settings_init(&settings));
    settings.dt = author.dt;
    settings.numerical_damping = author.numerical_damping;
    check(rom_simulation_new(model, &settings, &simulation));
    check(rom_simulation_start(simulation, load_case)); /* where the load case starts, at rest if it does not say */
    check(rom_loads_new(model, load_case, &point, 1, &loads));
    check(rom_model_state_layout(model, &layout));
    snapshot = malloc(3 * layout.size * sizeof *snapshot);
    if (snapshot == NULL) {
        return 1;
    }
    first = snapshot + layout.size;
    second = first + layout.size;

    steps = (size_t)(author.t_end / author.dt + 0.5);
    for (i = 0; i < steps; i++) {
        damped_step(simulation, loads, point);
    }
    check(rom_simulation_rigid(simulation, &rigid));
    check(rom_simulation_point(simulation, point, &tip));
    printf("%s after %g s: dR_A = (%.6f, %.6f, %.6f) m, w_G = (%.6f, %.6f, %.6f) rad/s\n", point_name, rigid.time,
           tip.dr_a[0], tip.dr_a[1], tip.dr_a[2], rigid.w_g[0], rigid.w_g[1], rigid.w_g[2]);

    check(rom_simulation_get_state(simulation, snapshot, layout.size));
    for (i = 0; i < 10; i++) {
        damped_step(simulation, loads, point);
    }
    check(rom_simulation_get_state(simulation, first, layout.size));
    check(rom_simulation_set_state(simulation, snapshot, layout.size));
    for (i = 0; i < 10; i++) {
        damped_step(simulation, loads, point);
    }
    check(rom_simulation_get_state(simulation, second, layout.size));
    if (memcmp(first, second, layout.size * sizeof *first) != 0) {
        fprintf(stderr, "the same ten steps gave other bits\n");
        return 1;
    }
    printf("ten steps, rewound and made again: the same bits\n");

    free(snapshot);
    rom_loads_free(loads);
    rom_model_free(model); /* the simulation keeps what it needs */
    check(rom_simulation_step(simulation, NULL) == ROM_BAD_ARGUMENT ? ROM_OK : ROM_INTERNAL);
    rom_simulation_free(simulation);
    return 0;
}
