//! Section 4.3.2, Figs 18 to 20: the frame on a descending turn.

use rom_generator::reference::method::Method;

use super::figure::{Figure, VIEW, curves, or_reason, paths, seen_from_above};
use super::linearisation::{ARM, peak, percent};
use super::runs::{Plan, Runs, SPIRAL_RIGID, row_at, spiral};
use super::statement::{Statement, close};
use crate::report::{Block, Look, Plot};
use crate::text::significant;
use crate::validate::norms::extreme_error;

const METHODS: [Method; 3] = [Method::Nonlinear, Method::Linear, Method::MeanAxes];
const DRAWN: [(&str, f64); 3] = [("a", 4.0), ("b", 10.0), ("c", 50.0)];

pub(super) fn figures(runs: &Runs, plan: &Plan) -> Vec<Figure> {
    vec![trajectory(runs, plan), deflections(runs), errors(runs, plan)]
}

/// Largest distance between the paths of the centre of mass up to `t_end`, over the largest distance of the reference from
/// its start.
fn apart(runs: &Runs, run: &str, reference: &str, t_end: f64) -> Result<f64, String> {
    let (a, b) = (runs.channel(run, "r_CM_G")?, runs.channel(reference, "r_CM_G")?);
    let rows = row_at(runs.get(reference)?, t_end) + 1;
    let distance = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
    let most = |f: &dyn Fn(usize) -> f64| (0..rows).map(f).fold(0.0, f64::max);
    Ok(most(&|i| distance(a.row(i), b.row(i))) / most(&|i| distance(b.row(i), b.row(0))))
}

fn trajectory(runs: &Runs, plan: &Plan) -> Figure {
    let plots = || {
        let mut blocks = Vec::new();
        for (part, sigma) in DRAWN {
            let mut tracks = Vec::new();
            let names = METHODS.map(|m| (m.to_string(), spiral(sigma, m)));
            for (label, run) in names.into_iter().chain([("rigid".to_owned(), SPIRAL_RIGID.to_owned())]) {
                let cm = runs.channel(&run, "r_CM_G")?;
                let seen =
                    (0..cm.rows()).map(|i| seen_from_above(&[cm.row(i)[0], cm.row(i)[1], cm.row(i)[2]]));
                let (x, y) = seen.map(|[x, y]| (x, y)).unzip();
                tracks.push((label, x, y));
            }
            let plot =
                paths(&format!("({part}) sigma = {sigma}, path of the centre of mass"), ["m", "m"], tracks);
            blocks.push(Block::Plot(Plot { note: VIEW.to_owned(), ..plot }));
        }
        Ok(blocks)
    };
    let up_to =
        |keep: &dyn Fn(f64) -> bool, compare: &dyn Fn(f64, f64) -> Result<f64, String>, t_end: f64| {
            let sigmas = plan.spiral_sigmas.iter().filter(|s| keep(**s));
            let errors = sigmas.map(|&s| compare(s, t_end)).collect::<Result<Vec<f64>, String>>()?;
            Ok::<f64, String>(errors.into_iter().fold(0.0, f64::max))
        };
    let linear = |s: f64, t: f64| apart(runs, &spiral(s, Method::Linear), &spiral(s, Method::Nonlinear), t);
    let rigid = |s: f64, t: f64| apart(runs, SPIRAL_RIGID, &spiral(s, Method::Nonlinear), t);
    let statements = vec![
        Statement::check("Fig. 18", "the rigid frame circles with radius 80 m around (80, 0)", || {
            let cm = runs.channel(SPIRAL_RIGID, "r_CM_G")?;
            let radius = |i: usize| (cm.row(i)[0] - 80.0).hypot(cm.row(i)[1]);
            let (low, high) = (0..cm.rows()).map(radius).fold((f64::MAX, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
            Ok((format!("its distance from there is {} … {} m", significant(low, 4), significant(high, 4)), low > 78.0 && high < 82.0))
        }),
        Statement::check("Fig. 18", "the rigid frame sinks 421 m", || {
            let cm = runs.channel(SPIRAL_RIGID, "r_CM_G")?;
            let sunk = cm.row(0)[2] - cm.row(cm.rows() - 1)[2];
            Ok((format!("{} m", significant(sunk, 4)), close(sunk, 421.0, 0.01)))
        }),
        Statement::check("Fig. 18", "sigma >= 10: linear within 3.2 % of nonlinear in the trajectory", || {
            let (all, to_70) = (up_to(&|s| s >= 10.0, &linear, 80.0)?, up_to(&|s| s >= 10.0, &linear, 70.0)?);
            Ok((format!("at most {} ({} up to 70 s)", percent(all), percent(to_70)), all < 0.032))
        })
        .remark("Largest distance over the largest distance of the reference from its start. Towards 80 s the yaw begins to lose stability."),
        Statement::check("Fig. 18", "sigma >= 50: the motion is the rigid one within 1 %", || {
            let (all, to_70) = (up_to(&|s| s >= 50.0, &rigid, 80.0)?, up_to(&|s| s >= 50.0, &rigid, 70.0)?);
            Ok((format!("at most {} ({} up to 70 s)", percent(all), percent(to_70)), all < 0.01))
        }),
        Statement::check("Fig. 18", "sigma = 4: linear and nonlinear differ much", || {
            let e = linear(4.0, 80.0)?;
            Ok((percent(e), e > 0.05))
        }),
    ];
    Figure {
        name: "Fig. 18",
        title: "spiral, trajectories".to_owned(),
        text: "Path of the centre of mass for 80 s, 60 elements, dt = 0.1 s. The paper prints the fraction of MC upside down; it is Jz FT / \
            (m RS) here, which turns the frame with its path, and the centripetal force follows the speed of the rigid frame, an explicit \
            function of time (with the instantaneous speed, as the text could be read, the motion is unstable even for a rigid body)."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn deflections(runs: &Runs) -> Figure {
    let plots = || {
        let mut blocks = Vec::new();
        for (part, sigma) in DRAWN {
            let mut series = Vec::new();
            for method in METHODS {
                let z = runs.channel(&spiral(sigma, method), "Q.dR_A")?.column(2).map(|z| z / ARM);
                series.push((method.to_string(), z.collect()));
            }
            let t = &runs.channel(&spiral(sigma, Method::Nonlinear), "t")?.data;
            let title = format!("({part}) sigma = {sigma}");
            blocks.push(Block::Plot(curves(&title, ["t (s)", "dR_z / L2 of Q"], t, series)));
        }
        Ok(blocks)
    };
    let mut statements: Vec<Statement> = [(4.0, -0.1, -0.096), (10.0, -0.04, -0.043), (50.0, -0.01, -0.009)]
        .into_iter()
        .map(|(sigma, paper, prototype)| {
            let says = format!(
                "sigma = {sigma}: largest dR_z / L2 about {paper} (independent computation {prototype})"
            );
            Statement::check("Fig. 19", says, || {
                let z = peak(runs, &spiral(sigma, Method::Nonlinear), "Q")?.0;
                Ok((significant(z, 3), close(z, prototype, 0.06)))
            })
        })
        .collect();
    statements.push(Statement::check(
        "Fig. 19",
        "sigma = 4: linear over-predicts the deflection, mean axes are closer",
        || {
            let mut peaks = [0.0; 3];
            for (value, method) in peaks.iter_mut().zip(METHODS) {
                *value = peak(runs, &spiral(4.0, method), "Q")?.0.abs();
            }
            let [n, l, m] = peaks;
            let found = format!(
                "nonlinear {}, linear {}, mean axes {}",
                significant(n, 3),
                significant(l, 3),
                significant(m, 3)
            );
            Ok((found, l > n && (m - n).abs() < (l - n).abs()))
        },
    ));
    Figure {
        name: "Fig. 19",
        title: "spiral, tip displacement".to_owned(),
        text: "Vertical displacement over L2 = 5 m of the tip outside the circle, which is Q in the axes used here; the paper calls it P."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn errors(runs: &Runs, plan: &Plan) -> Figure {
    let of = |sigma: f64, method: Method| {
        let channel = |method| runs.channel(&spiral(sigma, method), "Q.dR_A");
        extreme_error(channel(method)?, channel(Method::Nonlinear)?, 2)
            .ok_or_else(|| "no displacement".to_owned())
    };
    let over = |method: Method, keep: &dyn Fn(f64) -> bool| {
        let chosen = plan.spiral_sigmas.iter().filter(|s| keep(**s));
        chosen.map(|&s| of(s, method)).collect::<Result<Vec<f64>, String>>()
    };
    let plots = || {
        let series =
            [Method::Linear, Method::MeanAxes].map(|m| Ok::<_, String>((m.to_string(), over(m, &|_| true)?)));
        let series = series.into_iter().collect::<Result<Vec<_>, String>>()?;
        let labels = ["stiffness parameter sigma", "relative error"];
        let plot =
            curves("Error of the largest dR_z of Q against nonlinear", labels, &plan.spiral_sigmas, series);
        Ok(vec![Block::Plot(Plot { look: Look { markers: true, ..Look::default() }, ..plot })])
    };
    let statements = vec![
        Statement::check(
            "Fig. 20",
            "sigma > 20: mean axes keep an error of about 12 % in the largest tip displacement",
            || {
                let errors = over(Method::MeanAxes, &|s| s > 20.0)?;
                let (low, high) = errors.iter().fold((f64::MAX, 0.0_f64), |(a, b), &e| (a.min(e), b.max(e)));
                Ok((format!("{} to {}", percent(low), percent(high)), low > 0.10 && high < 0.14))
            },
        ),
        Statement::check("Fig. 20", "sigma < 8: mean axes err less than linear", || {
            let (linear, mean) = (over(Method::Linear, &|s| s < 8.0)?, over(Method::MeanAxes, &|s| s < 8.0)?);
            let all: Vec<String> = plan
                .spiral_sigmas
                .iter()
                .zip(linear.iter().zip(&mean))
                .map(|(s, (l, m))| format!("sigma = {s}: {} against {}", percent(*m), percent(*l)))
                .collect();
            Ok((all.join("; "), linear.iter().zip(&mean).all(|(l, m)| m < l)))
        }),
        Statement::check("Fig. 20", "linear converges to nonlinear as sigma grows", || {
            let last = plan.spiral_sigmas.last().copied().unwrap_or(0.0);
            let (e, at_ten) = (of(last, Method::Linear)?, of(10.0, Method::Linear)?);
            Ok((
                format!("{} at sigma = 10, {} at sigma = {last}", percent(at_ten), percent(e)),
                e < at_ten && e < 0.02,
            ))
        }),
    ];
    Figure {
        name: "Fig. 20",
        title: "spiral, error of the largest tip displacement".to_owned(),
        text: "Relative error of max |dR_z| of the outer tip, linear and mean axes against nonlinear, over sigma.".to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}
