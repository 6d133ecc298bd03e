//! Section 4.3.1, Figs 15 and 16: mean axes under load case 2.

use rom_generator::reference::method::Method;

use super::figure::{Figure, curves, or_reason};
use super::linearisation::{ARM, error, peak, percent};
use super::runs::{Plan, Runs, Swept, lc2, plotted};
use super::statement::Statement;
use crate::report::{Block, Look, Plot};
use crate::text::significant;

pub(super) fn figures(runs: &Runs, plan: &Plan) -> Vec<Figure> {
    vec![errors(runs, plan), deflections(runs, plan)]
}

fn errors(runs: &Runs, plan: &Plan) -> Figure {
    let sigmas: Vec<f64> = plan.sigmas.iter().copied().filter(|s| *s >= 10.0).collect();
    let of = |sigma: f64, name: &str| {
        error(runs, &lc2(sigma, Method::MeanAxes), &lc2(sigma, Method::Linear), name)
    };
    let over = |name: &str, keep: fn(f64) -> bool| Swept::new(&sigmas, keep, |s| of(s, name));
    let plots = || {
        let series = vec![
            ("w_G".to_owned(), plotted(&sigmas, |s| of(s, "w_G"))),
            ("P.dR_A".to_owned(), plotted(&sigmas, |s| of(s, "P.dR_A"))),
        ];
        let plot = curves(
            "Mean axes against linear",
            ["stiffness parameter sigma", "relative error"],
            &sigmas,
            series,
        );
        let look = Look { log_x: true, markers: true, ..Look::default() };
        Ok(vec![Block::Plot(Plot { look, ..plot })])
    };
    let statements = vec![
        Statement::check("Fig. 15", "sigma > 30: w_G within 5 %", || {
            let swept = over("w_G", |s| s > 30.0)?;
            let worst = swept.range().1;
            Ok((format!("at most {}{}", percent(worst), swept.missing), worst < 0.05))
        }),
        Statement::check(
            "Fig. 15",
            "the tip displacement keeps an error of about 17 % however stiff the frame",
            || {
                let stiff = over("P.dR_A", |s| s >= 30.0)?;
                let (low, high) = stiff.range();
                let found = format!("{} to {} for sigma >= 30{}", percent(low), percent(high), stiff.missing);
                Ok((found, low > 0.16 && high < 0.19))
            },
        ),
    ];
    Figure {
        name: "Fig. 15",
        title: "mean axes against linear".to_owned(),
        text: "Maximum relative error norms over sigma >= 10, load case 2, with 40 modes of the mean axes (more change nothing). The \
            rigid-body equations of this method are about the centre of mass; w_G is the same at any point, and v_G is left out, as in \
            the paper."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn deflections(runs: &Runs, plan: &Plan) -> Figure {
    const METHODS: [(&str, Method); 3] =
        [("nonlinear", Method::Nonlinear), ("linear", Method::Linear), ("mean-axes", Method::MeanAxes)];
    let plots = || {
        let mut blocks = Vec::new();
        for (part, sigma) in [("a", 5.0), ("b", 10.0), ("c", 30.0)] {
            let mut series = Vec::new();
            for (name, method) in METHODS {
                let z = runs.channel(&lc2(sigma, method), "P.dR_A")?.column(2).map(|z| z / ARM);
                series.push((name.to_owned(), z.collect()));
            }
            let t = &runs.channel(&lc2(sigma, Method::Nonlinear), "t")?.data;
            let title = format!("({part}) sigma = {sigma}");
            blocks.push(Block::Plot(curves(&title, ["t (s)", "dR_z / L2 of P"], t, series)));
        }
        Ok(blocks)
    };
    let peaks = |sigma: f64| {
        let mut peaks = [0.0; 3];
        for (value, (_, method)) in peaks.iter_mut().zip(METHODS) {
            *value = peak(runs, &lc2(sigma, method), "P")?.0.abs();
        }
        Ok::<[f64; 3], String>(peaks)
    };
    let told = |all: &[(f64, [f64; 3])]| {
        let one = |(sigma, p): &(f64, [f64; 3])| {
            let [n, l, m] = p.map(|p| significant(p, 3));
            format!("sigma = {sigma}: nonlinear {n}, linear {l}, mean axes {m}")
        };
        all.iter().map(one).collect::<Vec<_>>().join("; ")
    };
    let drawn =
        || [5.0, 10.0, 30.0].into_iter().map(|s| Ok((s, peaks(s)?))).collect::<Result<Vec<_>, String>>();
    let statements = vec![
        Statement::check("Fig. 16", "linear over-predicts the deflection", || {
            let all = drawn()?;
            Ok((told(&all), all.iter().all(|(_, [n, l, _])| l > n)))
        }),
        Statement::check(
            "Fig. 16",
            "mean axes give smaller deflections than linear, whatever the stiffness",
            || {
                let ratio = |s: f64| peaks(s).map(|[_, l, m]| m / l);
                let ratios = Swept::new(&plan.sigmas, |_| true, ratio)?;
                let (low, high) = ratios.range();
                let found = format!(
                    "peaks {} to {} of those of linear{}",
                    significant(low, 3),
                    significant(high, 3),
                    ratios.missing
                );
                Ok((found, high < 1.0))
            },
        ),
        Statement::check("Fig. 16", "sigma = 5: mean axes match nonlinear closer than linear", || {
            let [n, l, m] = peaks(5.0)?;
            let off = |x: f64| percent((x / n - 1.0).abs());
            Ok((
                format!("peak off by {} with mean axes, {} with linear", off(m), off(l)),
                (m - n).abs() < (l - n).abs(),
            ))
        }),
        Statement::check("Fig. 16", "sigma >= 30: the error of mean axes is largest at t = 9.35 s", || {
            let time = |sigma: f64| {
                let com = runs.channel(&lc2(sigma, Method::MeanAxes), "P.dR_A")?;
                let reference = runs.channel(&lc2(sigma, Method::Linear), "P.dR_A")?;
                let distance =
                    |i: usize| (0..3).map(|k| (com.row(i)[k] - reference.row(i)[k]).powi(2)).sum::<f64>();
                let worst = (0..com.rows()).max_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
                Ok(runs.channel(&lc2(sigma, Method::Linear), "t")?.data[worst])
            };
            let (low, high) = Swept::new(&plan.sigmas, |s| s >= 30.0, time)?.range();
            let found =
                format!("between {} and {} s, against linear", significant(low, 4), significant(high, 4));
            Ok((found, low > 9.2 && high < 9.5))
        }),
    ];
    Figure {
        name: "Fig. 16",
        title: "tip displacement by three methods".to_owned(),
        text: "Vertical displacement of P over L2 = 5 m, load case 2. The paper's references to equations in this paragraph say (22) for \
            the linearised method, which is the fully linearised one; its curves are those of (21), linear in the elasticity only."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}
