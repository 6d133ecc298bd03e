//! Section 4.1: the flying flexible beam.

use super::figure::{Figure, or_reason, paths, snapshots};
use super::runs::{BEAM_10, BEAM_COARSE_STEP, BEAM_FINE, BEAM_LONG, BEAM_PLANAR, Runs, row_at, shape};
use super::statement::{Statement, close};
use crate::report::Block;
use crate::results::Results;
use crate::text::significant;

/// Mass of the beam, kg, and its length, m.
const MASS: f64 = 10.0;
const LENGTH: f64 = 10.0;

pub(super) fn figures(runs: &Runs) -> Vec<Figure> {
    vec![planar(runs), spatial(runs), travel(runs)]
}

/// Nodes of a beam of so many elements, from A to B.
fn nodes(elements: usize) -> Vec<usize> {
    (0..=elements).collect()
}

fn shapes(results: &Results, elements: usize, times: &[f64]) -> Vec<(f64, Vec<[f64; 3]>)> {
    times.iter().map(|&t| (t, shape(results, &nodes(elements), t))).collect()
}

/// Largest distance between the same nodes of two runs at the given times, over the length of the beam.
fn apart(a: (&Results, usize), b: (&Results, usize), times: &[f64]) -> f64 {
    let pick = |(results, elements): (&Results, usize), t: f64| {
        let all = shape(results, &nodes(elements), t);
        all.into_iter().step_by(elements / 10).collect::<Vec<_>>()
    };
    let distance = |t: f64| {
        let pairs = pick(a, t).into_iter().zip(pick(b, t));
        pairs.map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()).fold(0.0, f64::max)
    };
    times.iter().map(|&t| distance(t)).fold(0.0, f64::max) / LENGTH
}

fn planar(runs: &Runs) -> Figure {
    let times: Vec<f64> = (0..=20).map(|i| 0.5 * f64::from(i)).collect();
    let plots = || {
        let plot = |run: &str| {
            let shapes = shapes(runs.get(run)?, 10, &times);
            Ok(Block::Plot(snapshots(
                &format!("Planar beam, {}", run.trim_start_matches("planar beam, ")),
                ["x (m)", "z (m)"],
                [0, 2],
                &shapes,
            )))
        };
        [BEAM_PLANAR, BEAM_COARSE_STEP].into_iter().map(plot).collect::<Result<Vec<_>, String>>()
    };
    let difference =
        |a: &str, b: &str| Ok::<f64, String>(apart((runs.get(a)?, 10), (runs.get(b)?, 10), &times));
    let statements = vec![
        centre_speed(runs, "Fig. 3", BEAM_PLANAR, 2.5, 2.0),
        centre_travel(runs, "Fig. 3", BEAM_PLANAR, 10.0, 17.5),
        Statement::check("Fig. 3", "the moment about +y tumbles the beam forward, along +x", || {
            let lead = runs.channel(BEAM_PLANAR, "B.R_G")?;
            let trail = runs.channel(BEAM_PLANAR, "A.R_G")?;
            let ahead = lead.column(0).zip(trail.column(0)).map(|(b, a)| b - a).fold(f64::MIN, f64::max);
            Ok((format!("the far end, 6 m behind A at first, gets {} m ahead of it", significant(ahead, 3)), ahead > 0.0))
        }),
        Statement::check("Fig. 3", "dt = 0.1 s differs visibly from the converged solution", || {
            let d = difference(BEAM_COARSE_STEP, BEAM_FINE)?;
            Ok((format!("positions differ by up to {} % of the length from dt = 0.005 s", significant(100.0 * d, 2)), d > 0.01))
        }),
        Statement::check("Fig. 3", "dt = 0.01 s is needed, and gives a converged solution", || {
            let (fine, coarse) = (difference(BEAM_PLANAR, BEAM_FINE)?, difference(BEAM_COARSE_STEP, BEAM_FINE)?);
            let found = format!(
                "up to {} % of the length from dt = 0.005 s ({} times less than with dt = 0.1 s)",
                significant(100.0 * fine, 2),
                significant(coarse / fine, 2)
            );
            Ok((found, fine < 0.05 && fine < 0.2 * coarse))
        })
        .remark("Positions are compared. Rates at mid-span do not converge: the moment's step excites undamped bending of any frequency the mesh has."),
    ];
    Figure {
        name: "Fig. 3",
        title: "planar flying beam, shapes every 0.5 s".to_owned(),
        text: "Side view of the 2-D beam, 10 two-node elements, from t = 0 (light) to 10 s (dark), with the step that converges and \
            with the original one. The shapes of Simo & Vu-Quoc are lost with the paper's figures and cannot be compared."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn spatial(runs: &Runs) -> Figure {
    const SIDE: [f64; 10] = [0.0, 2.0, 3.0, 3.8, 4.4, 5.0, 5.5, 5.8, 6.1, 6.5];
    const END: [f64; 5] = [0.0, 2.5, 3.5, 3.8, 4.5];
    let plots = || {
        let (fine, coarse) = (runs.get(BEAM_LONG)?, runs.get(BEAM_10)?);
        let mut blocks = Vec::new();
        for (results, elements) in [(fine, 20), (coarse, 10)] {
            let title = |plane: &str| format!("{plane} plane, {elements} elements");
            let (side, end) = (shapes(results, elements, &SIDE), shapes(results, elements, &END));
            blocks.push(Block::Plot(snapshots(&title("x-z"), ["x (m)", "z (m)"], [0, 2], &side)));
            blocks.push(Block::Plot(snapshots(&title("y-z"), ["y (m)", "z (m)"], [1, 2], &end)));
        }
        Ok(blocks)
    };
    let statements = vec![
        Statement::check("Fig. 4", "10 and 20 elements give nearly the same shapes", || {
            let d = apart((runs.get(BEAM_LONG)?, 20), (runs.get(BEAM_10)?, 10), &SIDE);
            Ok((
                format!("at the times drawn, up to {} % of the length apart", significant(100.0 * d, 2)),
                d < 0.1,
            ))
        })
        .remark("Read from the figure's legend and the text's \"converged solution\"; no number is given."),
        Statement::check("Fig. 4", "the second moment causes motion out of the plane", || {
            let b = runs.channel(BEAM_LONG, "B.R_G")?;
            let until = row_at(runs.get(BEAM_LONG)?, 6.5);
            let out = (0..=until).map(|i| b.row(i)[1].abs()).fold(0.0, f64::max);
            Ok((format!("the far end moves up to {} m along y by 6.5 s", significant(out, 3)), out > 1.0))
        }),
    ];
    Figure {
        name: "Fig. 4",
        title: "spatial flying beam".to_owned(),
        text: "The 3-D beam at the times the paper draws: x-z plane at 0, 2, 3, 3.8, 4.4, 5, 5.5, 5.8, 6.1 and 6.5 s, y-z plane at 0, \
            2.5, 3.5, 3.8 and 4.5 s (light to dark). The shapes of Hsiao et al. are lost and cannot be compared."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn travel(runs: &Runs) -> Figure {
    let plots = || {
        let results = runs.get(BEAM_LONG)?;
        let times: Vec<f64> = (0..=50).map(|i| 0.4 * f64::from(i)).collect();
        let until = row_at(results, 20.0) + 1;
        let track = |label: &str, channel: &str| {
            let channel = runs.channel(BEAM_LONG, channel)?;
            let column = |k: usize| channel.column(k).take(until).collect();
            Ok::<_, String>((label.to_owned(), column(0), column(2)))
        };
        let tracks = [track("A", "A.R_G")?, track("B", "B.R_G")?, track("centre of mass", "r_CM_G")?];
        Ok(vec![
            Block::Plot(snapshots(
                "Shapes every 0.4 s",
                ["x (m)", "z (m)"],
                [0, 2],
                &shapes(results, 20, &times),
            )),
            Block::Plot(paths("Both tips and the centre of mass", ["x (m)", "z (m)"], tracks.to_vec())),
        ])
    };
    let statements = vec![
        centre_speed(runs, "Fig. 5", BEAM_LONG, 5.0, 5.0),
        centre_travel(runs, "Fig. 5", BEAM_LONG, 20.0, 87.5),
        Statement::check("Fig. 5", "the centre of mass moves along the x direction", || {
            let cm = runs.channel(BEAM_LONG, "r_CM_G")?;
            let start = cm.row(0).to_vec();
            let aside = (0..cm.rows()).map(|i| (cm.row(i)[1] - start[1]).hypot(cm.row(i)[2] - start[2]));
            let aside = aside.fold(0.0, f64::max);
            Ok((
                format!("it strays up to {} m from that line by 50 s", significant(aside, 2)),
                aside < 0.01 * 87.5,
            ))
        }),
        Statement::check(
            "Fig. 5",
            "dt = 0.01 s: error of the centre of mass's position below 1 % up to t = 50 s",
            || {
                let cm = runs.channel(BEAM_LONG, "r_CM_G")?;
                let t = runs.channel(BEAM_LONG, "t")?;
                let (mut difference, mut length) = (0.0, 0.0);
                for (i, &t) in t.data.iter().enumerate() {
                    let exact = [cm.row(0)[0] + exact_travel(t), cm.row(0)[1], cm.row(0)[2]];
                    difference += (0..3).map(|k| (cm.row(i)[k] - exact[k]).powi(2)).sum::<f64>();
                    length += exact.iter().map(|x| x * x).sum::<f64>();
                }
                let error = (difference / length).sqrt();
                Ok((format!("{} % (L2 norm over time)", significant(100.0 * error, 2)), error < 0.01))
            },
        ),
    ];
    Figure {
        name: "Fig. 5",
        title: "travel of the spatial beam".to_owned(),
        text: "Side view until t = 20 s: shapes every 0.4 s (light to dark), and the paths of both tips and of the centre of mass."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

/// Travel of a particle of 10 kg under the force that rises to 20 N at 2.5 s and falls to zero at 5 s.
fn exact_travel(t: f64) -> f64 {
    let rate = 8.0 / MASS;
    let rise = |t: f64| rate * t.max(0.0).powi(3) / 6.0;
    rise(t) - 2.0 * rise(t - 2.5) + rise(t - 5.0)
}

/// The centre of mass is a particle: its speed at a time.
fn centre_speed(runs: &Runs, figure: &'static str, run: &str, t: f64, exact: f64) -> Statement {
    Statement::check(
        figure,
        format!("exact: the centre of mass moves at {exact} m/s along x after {t} s"),
        || {
            let p = runs.channel(run, "p_G")?;
            let speed = p.row(row_at(runs.get(run)?, t))[0] / MASS;
            Ok((format!("{} m/s", significant(speed, 6)), close(speed, exact, 0.01)))
        },
    )
}

fn centre_travel(runs: &Runs, figure: &'static str, run: &str, t: f64, exact: f64) -> Statement {
    Statement::check(
        figure,
        format!("exact: the centre of mass has travelled {exact} m along x by {t} s"),
        || {
            let cm = runs.channel(run, "r_CM_G")?;
            let travel = cm.row(row_at(runs.get(run)?, t))[0] - cm.row(0)[0];
            Ok((format!("{} m", significant(travel, 6)), close(travel, exact, 0.01)))
        },
    )
}

#[cfg(test)]
mod tests {
    /// 5 m/s after 5 s, 12.5 m until then (by symmetry half of 5 s x 5 m/s), then uniform: 87.5 m by 20 s.
    #[test]
    fn travel_of_a_particle() {
        assert!((super::exact_travel(5.0) - 12.5).abs() < 1e-12);
        assert!((super::exact_travel(20.0) - 87.5).abs() < 1e-12);
    }
}
