//! Section 4.2.2, Figs 9 to 11: the frame under load case 2 and what linearising its elasticity costs.

use rom_generator::reference::method::Method;

use super::figure::{Figure, curves, or_reason, over_sigma};
use super::frame::{extremes, history};
use super::runs::{Plan, Runs, Swept, lc2, plotted};
use super::statement::{Statement, close};
use crate::report::Block;
use crate::text::significant;
use crate::validate::norms::relative_error;

/// Length of the arms, m: displacements are given over it.
pub(super) const ARM: f64 = 5.0;

pub(super) fn figures(runs: &Runs, plan: &Plan) -> Vec<Figure> {
    vec![velocities(runs), deflections(runs, plan), errors(runs, plan)]
}

/// Relative error of a quantity in a run against another.
pub(super) fn error(runs: &Runs, run: &str, reference: &str, name: &str) -> Result<f64, String> {
    relative_error(runs.channel(run, name)?, runs.channel(reference, name)?, 0.0)
        .ok_or_else(|| format!("{reference} has no {name}"))
}

pub(super) fn percent(fraction: f64) -> String {
    format!("{} %", significant(100.0 * fraction, 3))
}

/// The extreme of `dR_z / L2` of a point farthest from zero, and when.
pub(super) fn peak(runs: &Runs, run: &str, point: &str) -> Result<(f64, f64), String> {
    let (channel, t) = (runs.channel(run, &format!("{point}.dR_A"))?, runs.channel(run, "t")?);
    let farthest = channel.column(2).zip(&t.data).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    farthest.map(|(z, t)| (z / ARM, *t)).ok_or_else(|| format!("{run} has no row"))
}

fn velocities(runs: &Runs) -> Figure {
    let run = lc2(10.0, Method::Nonlinear);
    let plots = || {
        Ok(vec![
            Block::Plot(history(runs, &run, "v_G", "Velocity of A, components in G")?),
            Block::Plot(history(runs, &run, "w_G", "Angular velocity of A, components in G")?),
        ])
    };
    let statements = vec![
        Statement::check("Fig. 9", "v_G about ±0.55 m/s", || {
            let (low, high) = extremes(runs.channel(&run, "v_G")?);
            let found = format!("{} … {} m/s", significant(low, 3), significant(high, 3));
            Ok((found, close(high, 0.55, 0.05) && close(low, -0.55, 0.05)))
        }),
        Statement::check("Fig. 9", "w_G about -0.75 … 0.87 rad/s", || {
            let (low, high) = extremes(runs.channel(&run, "w_G")?);
            let found = format!("{} … {} rad/s", significant(low, 3), significant(high, 3));
            Ok((found, close(low, -0.75, 0.02) && close(high, 0.87, 0.02)))
        }),
        Statement::check("Fig. 9", "exact (dead couples only): the centre of mass stays where it is", || {
            let cm = runs.channel(&run, "r_CM_G")?;
            let away = |i: usize| (0..3).map(|k| (cm.row(i)[k] - cm.row(0)[k]).powi(2)).sum::<f64>().sqrt();
            let most = (0..cm.rows()).map(away).fold(0.0, f64::max);
            Ok((format!("it strays up to {} m", significant(most, 2)), most < 1e-6))
        }),
    ];
    Figure {
        name: "Fig. 9",
        title: "rigid-body velocities under load case 2".to_owned(),
        text: "Nonlinear method, sigma = 10.".to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn deflections(runs: &Runs, plan: &Plan) -> Figure {
    let nonlinear = |sigma: f64| lc2(sigma, Method::Nonlinear);
    let plots = || {
        let t = &runs.channel(&nonlinear(10.0), "t")?.data;
        let mut series = Vec::new();
        for sigma in [3.0, 5.0, 10.0, 100.0] {
            let z = runs.channel(&nonlinear(sigma), "P.dR_A")?.column(2).map(|z| z / ARM);
            series.push((format!("sigma = {sigma}"), z.collect()));
        }
        let mut largest = ["x", "y", "z"].map(|c| (format!("|dR_{c}|"), Vec::new())).to_vec();
        for &sigma in &plan.sigmas {
            let channel = runs.channel(&nonlinear(sigma), "P.dR_A")?;
            for (j, (_, values)) in largest.iter_mut().enumerate() {
                values.push(channel.column(j).fold(0.0_f64, |m, v| m.max(v.abs())) / ARM);
            }
        }
        let labels = ["t (s)", "dR_z / L2"];
        Ok(vec![
            Block::Plot(curves("(a) Vertical displacement of P over L2", labels, t, series)),
            Block::Plot(over_sigma(
                "(b) Largest displacement of P over L2",
                "max |dR_A| / L2",
                &plan.sigmas,
                largest,
            )),
        ])
    };
    let mut statements: Vec<Statement> = [(3.0, -0.23), (5.0, -0.15), (10.0, -0.075), (30.0, -0.025)]
        .into_iter()
        .map(|(sigma, expected)| {
            Statement::check(
                "Fig. 10",
                format!("sigma = {sigma}: dR_z / L2 of P reaches about {expected}"),
                || {
                    let (z, t) = peak(runs, &nonlinear(sigma), "P")?;
                    Ok((
                        format!("{} at t = {} s", significant(z, 3), significant(t, 3)),
                        close(z, expected, 0.1),
                    ))
                },
            )
        })
        .collect();
    statements.push(Statement::check("Fig. 10", "the peaks are near t = 9.3 s", || {
        let times = [3.0, 5.0, 10.0, 30.0].map(|sigma| peak(runs, &nonlinear(sigma), "P").map(|(_, t)| t));
        let times = times.into_iter().collect::<Result<Vec<f64>, String>>()?;
        let list: Vec<String> = times.iter().map(|&t| significant(t, 3)).collect();
        Ok((
            format!("at {} s for sigma = 3, 5, 10, 30", list.join(", ")),
            times.iter().all(|t| (t - 9.3).abs() < 0.4),
        ))
    }));
    statements.push(Statement::check(
        "Fig. 10",
        "the largest deflection falls like 1/sigma for large sigma",
        || {
            let (a, b) = (peak(runs, &nonlinear(100.0), "P")?.0, peak(runs, &nonlinear(1000.0), "P")?.0);
            let slope = (b / a).log10();
            Ok((
                format!("from sigma = 100 to 1000 like sigma to the power {}", significant(slope, 3)),
                (slope + 1.0).abs() < 0.03,
            ))
        },
    ));
    Figure {
        name: "Fig. 10",
        title: "tip displacement for varying stiffness".to_owned(),
        text: "Nonlinear method, load case 2; L2 = 5 m is the length of the arms.".to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn errors(runs: &Runs, plan: &Plan) -> Figure {
    let of = |method: Method, sigma: f64, name: &str| {
        error(runs, &lc2(sigma, method), &lc2(sigma, Method::Nonlinear), name)
    };
    let plots = || {
        let over = |method: Method, name: &str| plotted(&plan.sigmas, |sigma| of(method, sigma, name));
        let mut blocks = Vec::new();
        for (title, names) in
            [("(a) Rigid-body velocities", &["v_G", "w_G"][..]), ("(b) Displacement of P", &["P.dR_A"])]
        {
            let mut series = Vec::new();
            for method in [Method::Linear, Method::ConstantMass] {
                for name in names {
                    series.push((format!("{name}, {method}"), over(method, name)));
                }
            }
            blocks.push(Block::Plot(over_sigma(title, "relative error", &plan.sigmas, series)));
        }
        Ok(blocks)
    };
    let statements = error_statements(plan, &of);
    Figure {
        name: "Fig. 11",
        title: "linear and constant-mass against nonlinear".to_owned(),
        text: "Maximum relative error norms over sigma, load case 2: of the linear-flexible/nonlinear-rigid method (solid in the \
            paper) and of the nonlinear one with constant mass matrix (dashed in the paper)."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn error_statements(plan: &Plan, of: &impl Fn(Method, f64, &str) -> Result<f64, String>) -> Vec<Statement> {
    let list = |swept: &Swept| {
        let pairs: Vec<String> =
            swept.values.iter().map(|(s, e)| format!("{} at sigma = {s}", percent(*e))).collect();
        format!("{}{}", pairs.join(", "), swept.missing)
    };
    let soft = |method: Method, name: &str| Swept::new(&plan.sigmas, |s| s < 10.0, |s| of(method, s, name));
    let stiff = |method: Method, name: &str| Swept::new(&plan.sigmas, |s| s >= 10.0, |s| of(method, s, name));
    let above = |name: &'static str| {
        Statement::check(
            "Fig. 11",
            format!("sigma < 10: relative error of linear above 10 %, {name}"),
            || {
                let errors = soft(Method::Linear, name)?;
                Ok((list(&errors), errors.range().0 > 0.1))
            },
        )
    };
    let at_ten = |name: &'static str, expected: f64| {
        Statement::check(
            "Fig. 11",
            format!("sigma = 10: largest error of linear {expected} % in {name}"),
            || {
                let e = 100.0 * of(Method::Linear, 10.0, name)?;
                Ok((format!("{} %", significant(e, 3)), close(e, expected, 0.1)))
            },
        )
    };
    vec![
        above("P.dR_A"),
        above("v_G"),
        above("w_G").remark(
            "The text says so of the errors without naming one; by its own words that in w_G is about a tenth of that in v_G",
        ),
        at_ten("w_G", 2.4),
        at_ten("P.dR_A", 9.0),
        Statement::check("Fig. 11", "the errors of linear fall as sigma grows, sigma >= 10", || {
            let (mut found, mut falls) = (Vec::new(), true);
            for name in ["v_G", "w_G", "P.dR_A"] {
                let errors = stiff(Method::Linear, name)?.values;
                falls &= errors.windows(2).all(|w| w[1].1 < w[0].1);
                let ends = [errors.first(), errors.last()].map(|e| e.map_or(f64::NAN, |e| e.1));
                found.push(format!("{name} {} to {}", percent(ends[0]), percent(ends[1])));
            }
            Ok((found.join(", "), falls))
        }),
        Statement::check("Fig. 11", "the error of linear in v_G is an order of magnitude above that in w_G", || {
            let ratio = |s: f64| Ok(of(Method::Linear, s, "v_G")? / of(Method::Linear, s, "w_G")?);
            let (low, high) = Swept::new(&plan.sigmas, |s| s >= 10.0, ratio)?.range();
            let found = format!("{} to {} times, sigma >= 10", significant(low, 2), significant(high, 2));
            Ok((found, low > 3.0 && high < 30.0))
        }),
        Statement::check(
            "Fig. 11",
            "sigma >= 10: nonlinear with constant mass matrix has nearly the same rigid-body error as linear",
            || {
                let mut worst = 0.0_f64;
                for name in ["v_G", "w_G"] {
                    let ratio = |s: f64| Ok(of(Method::ConstantMass, s, name)? / of(Method::Linear, s, name)?);
                    let (low, high) = Swept::new(&plan.sigmas, |s| s >= 10.0, ratio)?.range();
                    worst = worst.max(high - 1.0).max(1.0 - low);
                }
                Ok((format!("the two errors differ by at most {} of that of linear", percent(worst)), worst < 0.2))
            },
        ),
        Statement::check("Fig. 11", "sigma < 10: constant mass matrix errs less than linear in dR_A", || {
            let constant = soft(Method::ConstantMass, "P.dR_A")?;
            let linear = soft(Method::Linear, "P.dR_A")?;
            let less = constant.values.iter().all(|(s, c)| linear.at(*s).is_none_or(|l| *c < l));
            Ok((list(&constant), less))
        }),
        irregularity(plan, of),
    ]
}

fn irregularity(plan: &Plan, of: &impl Fn(Method, f64, &str) -> Result<f64, String>) -> Statement {
    let says = "constant mass matrix: the error of dR_A has an irregularity for 30 <= sigma <= 60";
    Statement::check("Fig. 11", says, || {
        let near = |s: f64| (20.0..=80.0).contains(&s);
        let errors = Swept::new(&plan.sigmas, near, |s| of(Method::ConstantMass, s, "P.dR_A"))?.values;
        // On logarithmic axes a regular error is a straight line of slope about -1.
        let slope = |w: &[(f64, f64)]| (w[1].1 / w[0].1).ln() / (w[1].0 / w[0].0).ln();
        let slopes: Vec<f64> = errors.windows(2).map(slope).collect();
        let (low, high) = slopes.iter().fold((f64::MAX, f64::MIN), |(a, b), &s| (a.min(s), b.max(s)));
        let found = format!(
            "no: the error falls like sigma to a power between {} and {} there",
            significant(low, 3),
            significant(high, 3)
        );
        Ok((found.replacen("no: ", if high - low > 0.5 { "yes: " } else { "no: " }, 1), high - low > 0.5))
    })
    .remark("The paper leaves it unexplained and gives no number")
}
