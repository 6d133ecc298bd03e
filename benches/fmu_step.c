/* What a communication step of one internal step costs through FMI 2.0: fmu_step LIBRARY TOKEN RESOURCES(file://..) REFERENCE_OF_LOAD_CASE
 * LOAD_CASE REFERENCE_OF_DT DT REFERENCE_OF_INTEGRATOR INTEGRATOR. Prints the least time of a step over stretches of 200, ns. */
#define _POSIX_C_SOURCE 199309L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef void *instance;
struct callbacks { void (*log)(void *, const char *, int, const char *, const char *, ...); void *(*allocate)(size_t, size_t); void (*release)(void *); void *finished; void *environment; };

static void say(void *e, const char *name, int status, const char *category, const char *message, ...) { (void)e; (void)status; (void)category; fprintf(stderr, "%s: %s\n", name, message); }
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return 1e9 * (double)t.tv_sec + (double)t.tv_nsec; }
static void *library;
static void *function(const char *name) { void *f = dlsym(library, name); if (!f) { fprintf(stderr, "%s is missing\n", name); exit(1); } return f; }
static void good(int status) { if (status) { fprintf(stderr, "status %d\n", status); exit(1); } }

int main(int n, char **a) {
    if (n != 10 || !(library = dlopen(a[1], RTLD_NOW))) { fprintf(stderr, "%s\n", n == 10 ? dlerror() : "usage: see the source"); return 2; }
    instance (*instantiate)(const char *, int, const char *, const char *, const struct callbacks *, int, int) = function("fmi2Instantiate");
    int (*integer)(instance, const unsigned *, size_t, const int *) = function("fmi2SetInteger");
    int (*real)(instance, const unsigned *, size_t, const double *) = function("fmi2SetReal");
    int (*setup)(instance, int, double, double, int, double) = function("fmi2SetupExperiment");
    int (*enter)(instance) = function("fmi2EnterInitializationMode");
    int (*leave)(instance) = function("fmi2ExitInitializationMode");
    int (*step)(instance, double, double, int) = function("fmi2DoStep");
    struct callbacks callbacks = {say, calloc, free, NULL, NULL};
    instance it = instantiate("fmb", 1, a[2], a[3], &callbacks, 0, 0);
    if (!it) return 1;
    unsigned reference = (unsigned)atoi(a[4]);
    int load_case = atoi(a[5]);
    double dt = atof(a[7]), t = 0, best = 1e30;
    good(integer(it, &reference, 1, &load_case));
    reference = (unsigned)atoi(a[6]);
    good(real(it, &reference, 1, &dt));
    reference = (unsigned)atoi(a[8]);
    int integrator = atoi(a[9]);
    good(integer(it, &reference, 1, &integrator));
    good(setup(it, 0, 0, 0, 0, 0));
    good(enter(it));
    good(leave(it));
    /* From 2 s on: in motion. 4 s of it. */
    for (long i = 0, k = 0; t < 6; i++) {
        double start = now();
        for (k = 0; k < 200; k++, t += dt) good(step(it, t, dt, 1));
        double each = (now() - start) / 200;
        if (t > 2 && each < best) best = each;
    }
    printf("%.0f\n", best);
    return 0;
}
