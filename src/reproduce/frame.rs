//! Section 4.2.1, Figs 7 and 8: the frame under load case 1, and the published structure's shape.

use super::figure::{Figure, curves, or_reason, snapshots_3d};
use super::runs::{LC1, Plan, Runs, setup, shape};
use super::statement::{Statement, close};
use crate::published::FRAME;
use crate::report::{Block, Plot};
use crate::results::Channel;
use crate::text::significant;

pub(super) fn figures(runs: &Runs, plan: &Plan) -> Vec<Figure> {
    vec![motion(runs, plan), histories(runs)]
}

/// Nodes of the frame from the tip of the left arm to that of the right one.
pub(super) fn nodes(elements: usize) -> Result<Vec<usize>, String> {
    let mesh = setup(FRAME, &[("elements", elements as f64)], "lc1")?.mesh;
    let member = |name: &str| {
        let member = mesh.members.iter().find(|m| m.name == name);
        member.map(|m| m.nodes.clone()).ok_or_else(|| format!("the frame has no member {name}"))
    };
    let (left, right) = (member("left half beam")?, member("right half beam")?);
    let (left_arm, right_arm) = (member("left arm")?, member("right arm")?);
    let mut nodes: Vec<usize> = left_arm.into_iter().rev().chain(left.into_iter().rev()).collect();
    nodes.extend(right.into_iter().chain(right_arm));
    nodes.dedup();
    Ok(nodes)
}

/// Components of a vector over time.
pub(super) fn history(runs: &Runs, run: &str, channel: &str, title: &str) -> Result<Plot, String> {
    let channel = runs.channel(run, channel)?;
    let t = &runs.channel(run, "t")?.data;
    let series = channel.components.iter().enumerate().map(|(j, c)| (c.clone(), channel.column(j).collect()));
    Ok(curves(title, ["t (s)", &format!("{} ({})", channel.name, channel.unit)], t, series.collect()))
}

/// Smallest and largest component at any time.
pub(super) fn extremes(channel: &Channel) -> (f64, f64) {
    channel.data.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)))
}

fn motion(runs: &Runs, plan: &Plan) -> Figure {
    let plots = || {
        let results = runs.get(LC1)?;
        let nodes = nodes(plan.elements)?;
        let times = (0..=40).map(|i| 0.5 * f64::from(i));
        let shapes: Vec<_> = times.map(|t| (t, shape(results, &nodes, t))).collect();
        Ok(vec![Block::Plot(snapshots_3d("Load case 1, shapes every 0.5 s", &shapes))])
    };
    let statements =
        vec![Statement::check("Fig. 7", "the structure is subject to large deformations", || {
            let p = runs.channel(LC1, "P.dR_A")?;
            let peak =
                (0..p.rows()).map(|i| p.row(i).iter().map(|v| v * v).sum::<f64>().sqrt()).fold(0.0, f64::max);
            Ok((
                format!(
                    "P moves up to {} m in A, at the end of an arm of 5 m; all 20 s run with dt = 0.01 s",
                    significant(peak, 3)
                ),
                peak > 1.0,
            ))
        })];
    Figure {
        name: "Fig. 7",
        title: "the frame under load case 1".to_owned(),
        text: "Nonlinear motion at sigma = 1, from t = 0 (light) to 20 s (dark) every 0.5 s.".to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}

fn histories(runs: &Runs) -> Figure {
    let plots = || {
        Ok(vec![
            Block::Plot(history(runs, LC1, "P.R_G", "Position of P in G")?),
            Block::Plot(history(runs, LC1, "v_G", "Velocity of A, components in G")?),
            Block::Plot(history(runs, LC1, "w_G", "Angular velocity of A, components in G")?),
        ])
    };
    let last = |name: &str, k: usize| {
        let channel = runs.channel(LC1, name)?;
        Ok::<f64, String>(channel.row(channel.rows() - 1)[k])
    };
    let statements = vec![
        Statement::check("Fig. 8", "P reaches y of about 72 m at 20 s", || {
            let y = last("P.R_G", 1)?;
            Ok((format!("{} m", significant(y, 4)), close(y, 72.0, 0.03)))
        }),
        Statement::check(
            "Fig. 8",
            "exact (dead loads): the centre of mass moves at 9.26 m/s along y at 20 s",
            || {
                let v = last("p_G", 1)? / 405.0;
                Ok((format!("{} m/s", significant(v, 5)), close(v, 3750.0 / 405.0, 0.001)))
            },
        ),
        Statement::check("Fig. 8", "v_G between about -2 and 10 m/s (axes of the figure)", || {
            let (low, high) = extremes(runs.channel(LC1, "v_G")?);
            Ok((
                format!("{} … {} m/s", significant(low, 3), significant(high, 3)),
                low > -2.2 && high < 11.0 && high > 8.0,
            ))
        }),
        Statement::check("Fig. 8", "w_G between about -1 and 2 rad/s", || {
            let (low, high) = extremes(runs.channel(LC1, "w_G")?);
            let found = format!("{} … {} rad/s", significant(low, 3), significant(high, 3));
            Ok((found, (-1.5..-0.5).contains(&low) && (1.5..2.5).contains(&high)))
        }),
    ];
    Figure {
        name: "Fig. 8",
        title: "histories under load case 1".to_owned(),
        text: "Nonlinear method, sigma = 1, dt = 0.01 s. The paper's markers (SAMCEF Mecano) are lost and cannot be compared."
            .to_owned(),
        blocks: or_reason(plots()),
        statements,
    }
}
