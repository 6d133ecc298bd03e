/* An aerodynamic code in a loop: strip theory on a block of stations of a model. The air meets every strip with the velocity of the
 * strip itself, so that a wing that bends or pitches is damped; lift and speed are those of level flight of the whole aircraft.
 *
 *     cc strips.c $(pkg-config --cflags --libs rom) -lm -o strips && ./strips hale.rom gust wing
 */
#include <math.h>
#include <rom.h>
#include <stdio.h>
#include <stdlib.h>

#define SPEED 25.0      /* m/s, along x of A */
#define DENSITY 0.089   /* kg/m^3, at 20 km */
#define CHORD 1.0       /* m */
#define STRIP 1.0       /* m, along the span */
#define SLOPE 6.2831853 /* of the lift by the angle of incidence, 1/rad */

static void check(rom_status status)
{
    if (status != ROM_OK) {
        fprintf(stderr, "%s: %s\n", rom_status_text(status), rom_last_error());
        exit(1);
    }
}

/* Lift of each strip beyond that of level flight, which is among the loads of the equilibrium. Section axes: x along the span, y to the
 * rear, z up. */
static void strips(const double *velocity, const double *level, size_t n, double *wrenches)
{
    size_t i;
    for (i = 0; i < n; i++) {
        const double forward = -velocity[3 * i + 1], up = velocity[3 * i + 2];
        const double lift = 0.5 * DENSITY * CHORD * STRIP * SLOPE * forward * forward * atan2(-up, forward);
        double *wrench = wrenches + 6 * i;
        wrench[0] = wrench[1] = wrench[3] = wrench[4] = wrench[5] = 0.0;
        wrench[2] = lift - level[i];
    }
}

int main(int argc, char **argv)
{
    rom_model *model;
    rom_simulation *simulation;
    rom_loads *loads;
    rom_stations *stations;
    rom_settings settings = { .struct_size = sizeof settings };
    rom_state_layout layout = { .struct_size = sizeof layout };
    double *state, *velocity, *level, *wrenches, *sections;
    size_t block, n, i, k;

    if (argc < 4) {
        fprintf(stderr, "usage: strips MODEL LOAD_CASE BLOCK\n");
        return 2;
    }
    check(rom_model_read(argv[1], &model));
    check(rom_model_find_station_block(model, argv[3], &block));
    check(rom_stations_new(model, block, &stations));
    n = rom_stations_count(stations);
    check(rom_loads_new_with_stations(model, argv[2], NULL, 0, &block, 1, &loads));
    check(rom_settings_init(&settings));
    check(rom_simulation_new(model, &settings, &simulation));
    check(rom_model_state_layout(model, &layout));
    state = malloc(layout.size * sizeof *state);
    velocity = calloc(10 * n, sizeof *velocity);
    if (state == NULL || velocity == NULL) {
        return 1;
    }
    level = velocity + 3 * n;
    wrenches = velocity + 4 * n;

    check(rom_simulation_get_state(simulation, state, layout.size));
    state[layout.beta_star] = SPEED;
    state[layout.accelerations_known] = 0.0;
    check(rom_simulation_set_state(simulation, state, layout.size));
    check(rom_stations_read(stations, simulation, ROM_STATION_SECTION, n, NULL, NULL, velocity, NULL));
    strips(velocity, level, n, wrenches);
    for (i = 0; i < n; i++) {
        level[i] = wrenches[6 * i + 2];
    }
    for (k = 0; k < 200; k++) {
        check(rom_stations_read(stations, simulation, ROM_STATION_SECTION, n, NULL, NULL, velocity, NULL));
        strips(velocity, level, n, wrenches);
        check(rom_loads_set_stations(loads, 0, ROM_FRAME_NODE, wrenches, n));
        check(rom_simulation_step(simulation, loads));
    }
    for (i = 0; i < n; i++) {
        printf("strip %d of %d: lift beyond that of level flight %.6f N\n", (int)i + 1, (int)n, wrenches[6 * i + 2]);
    }
    /* Internal loads at the places that the structure file names, under what acts now. */
    n = rom_model_n_sections(model);
    sections = calloc(6 * n + 1, sizeof *sections);
    if (sections == NULL) {
        return 1;
    }
    check(rom_simulation_section_forces(simulation, loads, sections, 6 * n));
    for (i = 0; i < n; i++) {
        printf("%s: bending moment %.3f N m\n", rom_model_section_name(model, i), sections[6 * i + 4]);
    }
    free(sections);
    free(state);
    free(velocity);
    rom_stations_free(stations);
    rom_loads_free(loads);
    rom_simulation_free(simulation);
    rom_model_free(model);
    return 0;
}
