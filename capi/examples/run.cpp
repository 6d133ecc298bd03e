// A load case from start to end in C++, and the same by an integrator of our own on the derivatives.
//
//     c++ run.cpp $(pkg-config --cflags --libs rom) -o run && ./run fmb.rom lc2 P
#include <cmath>
#include <cstdio>
#include <rom.hpp>

namespace {

// Classical Runge-Kutta on the equations of motion.
void runge_kutta(rom::Evaluator &equations, const rom::Loads &loads, double t, double dt, std::vector<double> &y) {
    const std::size_t n = y.size();
    std::vector<double> sum(n), slope(n), stage(y);
    const double fraction[] = {0.5, 0.5, 1.0, 0.0}, weight[] = {1.0, 2.0, 2.0, 1.0}, at[] = {0.0, 0.5, 0.5, 1.0};
    for (int k = 0; k < 4; ++k) {
        equations.derivatives(t + at[k] * dt, stage.data(), loads, slope.data());
        for (std::size_t i = 0; i < n; ++i) {
            sum[i] += weight[k] * slope[i];
            stage[i] = y[i] + fraction[k] * dt * slope[i];
        }
    }
    for (std::size_t i = 0; i < n; ++i) y[i] += dt / 6.0 * sum[i];
}

} // namespace

int main(int argc, char **argv) {
    const std::string path = argc > 1 ? argv[1] : "fmb.rom", load_case = argc > 2 ? argv[2] : "lc2";
    try {
        const auto model = rom::Model::read(path);
        const auto author = model.load_case(load_case);
        const auto point = model.point(argc > 3 ? argv[3] : "P");
        auto settings = rom::settings();
        settings.dt = author.dt;
        settings.numerical_damping = author.numerical_damping;
        rom::Simulation simulation(model, settings);
        simulation.start(load_case);
        const rom::Loads loads(model, load_case);
        const auto steps = static_cast<std::uint64_t>(std::lround(author.t_end / author.dt));
        simulation.run(loads, steps);
        const auto tip = simulation.point(point);
        std::printf("Newmark:     dR_A = (%.17g, %.17g, %.17g)\n", tip.dr_a[0], tip.dr_a[1], tip.dr_a[2]);

        // One second with steps of a thousandth, beside the library's own Runge-Kutta.
        auto fine = rom::settings();
        fine.dt = 1e-3;
        fine.integrator = ROM_RK4;
        rom::Simulation own(model, fine);
        rom::Evaluator equations(model);
        const auto layout = model.state_layout();
        const auto start = own.state();
        std::vector<double> y(start.begin() + layout.q, start.begin() + layout.q + equations.n_variables());
        for (int i = 0; i < 1000; ++i) {
            runge_kutta(equations, loads, i * fine.dt, fine.dt, y);
            own.step(loads);
        }
        const auto end = own.state();
        double difference = 0.0, size = 0.0;
        for (std::size_t i = 0; i < y.size(); ++i) {
            difference = std::fmax(difference, std::fabs(y[i] - end[layout.q + i]));
            size = std::fmax(size, std::fabs(y[i]));
        }
        std::printf("Runge-Kutta: ours and the library's differ by %.1e of %.1e\n", difference, size);
        // The same method; the quaternion is brought back to unit length by one of them only, and it is not by much.
        if (!(difference < 1e-9 * size)) return 1;

        // A force of our own on the point, without the load case, and what the point then does.
        rom::Loads push(model, {point});
        push.add(0, ROM_FRAME_BODY, {{0.0, 0.0, 10.0}});
        own.step(push);
        const auto motion = own.point_motion(point, push);
        std::printf("Pushed:      a_G = (%.6f, %.6f, %.6f)\n", motion.a_g[0], motion.a_g[1], motion.a_g[2]);

        try {
            rom::Loads(model, "no such load case");
            return 1;
        } catch (const rom::Error &error) {
            std::printf("refused: %s\n", error.what());
            if (error.status() != ROM_NOT_FOUND) return 1;
        }
    } catch (const rom::Error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
