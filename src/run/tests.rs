use std::collections::BTreeMap;

use serde_json::Map;

use super::*;
use crate::results::{ChannelSpec, LEDGER, MOTION, Results, point_channels};

#[test]
fn a_quotient_off_by_round_off_is_a_whole_number_of_steps() {
    for (dt, t_end, steps) in
        [(0.01, 10.0, 1000), (0.1, 0.3, 3), (0.3, 1.0, 4), (1.0 / 3.0, 1.0, 3), (2.0, 1.0, 1)]
    {
        let grid = TimeGrid::new(dt, t_end, 1).unwrap();
        assert_eq!(grid.steps, steps, "{t_end} / {dt}");
        assert!(grid.time(grid.steps) >= t_end * (1.0 - 1e-9));
    }
    assert_eq!(TimeGrid::new(0.01, 10.0, 1).unwrap().to_string(), "");
    assert!(TimeGrid::new(0.3, 1.0, 1).unwrap().to_string().contains("ends at 1.2 s"));
}

#[test]
fn the_rows_written_are_as_many_as_announced() {
    for (t_end, every) in [(1.0, 1), (1.0, 3), (1.0, 4), (1.0, 100), (0.1, 1)] {
        let grid = TimeGrid::new(0.1, t_end, every).unwrap();
        let written = (0..=grid.steps).filter(|&i| grid.is_written(i)).count() as u64;
        assert_eq!(written, grid.rows(), "{t_end} every {every}");
        assert!(grid.is_written(0) && grid.is_written(grid.steps));
    }
}

#[test]
fn senseless_times_are_refused() {
    for (dt, t_end, every) in [
        (0.0, 1.0, 1),
        (-1.0, 1.0, 1),
        (f64::NAN, 1.0, 1),
        (0.1, 0.0, 1),
        (0.1, f64::INFINITY, 1),
        (0.1, 1.0, 0),
        (1e-12, 1.0, 1),
    ] {
        assert!(TimeGrid::new(dt, t_end, every).is_err(), "{dt} {t_end} {every}");
    }
}

#[test]
fn peaks_know_sign_and_time() {
    let mut peaks = Peaks::new(2);
    for (t, v) in [(0.0, [0.0, 0.0]), (1.0, [1.0, -3.0]), (2.0, [-2.0, 0.5])] {
        peaks.see(t, &v);
    }
    assert_eq!(peaks.length, (10.0_f64.sqrt(), 1.0));
    assert_eq!(peaks.at_longest, [1.0, -3.0]);
    assert_eq!(peaks.components[0].farthest(), (-2.0, 2.0));
    assert_eq!(peaks.components[1].min, (-3.0, 1.0));
}

/// A quarter turn about z at the end, moving along x, point P swinging, the centre of mass drifting.
fn sample() -> (RunFacts, Results, BTreeMap<String, Peaks>) {
    let facts = RunFacts {
        structure: "frame".to_owned(),
        file: "frame.rom".to_owned(),
        load_case: "lc".to_owned(),
        description: "a <case>".to_owned(),
        method: "rom".to_owned(),
        integrator: "newmark".to_owned(),
        numerical_damping: 0.01,
        grid: TimeGrid::new(0.5, 1.0, 1).unwrap(),
        command: "romrun frame.rom --loads lc".to_owned(),
        tool: "romrun 0".to_owned(),
        model: Vec::new(),
        loads: Vec::new(),
        input_text: String::new(),
    };
    let mut results = Results::new(Map::new());
    let specs = MOTION.into_iter().chain(LEDGER).map(ChannelSpec::from);
    let specs: Vec<ChannelSpec> =
        specs.chain([ChannelSpec::modal(&[1, 2])]).chain(point_channels("P")).collect();
    let index: Vec<usize> = specs.iter().map(|s| results.add(s, 3)).collect();
    let mut peaks = BTreeMap::from([("P.dR_A".to_owned(), Peaks::new(3)), ("v_G".to_owned(), Peaks::new(3))]);
    for step in 0..3 {
        let t = 0.5 * f64::from(step);
        let angle = t * std::f64::consts::FRAC_PI_2;
        let displacement = [0.0, -0.3 * t, 0.1];
        for (spec, &i) in specs.iter().zip(&index) {
            let zeta = [(angle / 2.0).cos(), 0.0, 0.0, (angle / 2.0).sin()];
            let row: Vec<f64> = match spec.name.as_str() {
                "t" => vec![t],
                "zeta" => zeta.to_vec(),
                "v_G" | "r_CM_G" => vec![t, 0.0, 0.0],
                "P.dR_A" => displacement.to_vec(),
                _ => vec![0.0; spec.components.len().max(1)],
            };
            results.push(i, &row);
        }
        peaks.get_mut("P.dR_A").unwrap().see(t, &displacement);
        peaks.get_mut("v_G").unwrap().see(t, &[t, 0.0, 0.0]);
    }
    (facts, results, peaks)
}

#[test]
fn the_summary_says_what_happened() {
    let (facts, results, peaks) = sample();
    let summary = Summary::new(&facts, &results, &peaks, 2, Timing::new(2, 0.5, 0.001));
    assert!(summary.completed);
    let point = &summary.points["P"];
    assert_eq!((point.peak_time, point.extreme_dr_a), (1.0, [0.0, -0.3, 0.1]));
    assert!((summary.last.rotation_deg - 90.0).abs() < 1e-9);
    assert_eq!(summary.last.rotation_axis, [0.0, 0.0, 1.0]);
    assert_eq!(summary.centre_of_mass_travel, 1.0);
    assert_eq!(summary.range["v_G"][0], [0.0, 1.0]);
    assert!((summary.timing.real_time_factor - 1000.0).abs() < 1e-6);
    let text = summary.to_text();
    assert!(text.contains("turned by 90 deg about (0, 0, 1)"), "{text}");
    assert!(text.contains("1,000 times real time"), "{text}");
}

#[test]
fn the_report_shows_every_channel_a_reader_asks_for() {
    let (facts, results, peaks) = sample();
    let mut summary = Summary::new(&facts, &results, &peaks, 2, Timing::new(2, 0.5, 0.001));
    summary.failure =
        Some(Failure { time: 1.0, message: "mode 3 diverged".to_owned(), help: "Halve --dt.".to_owned() });
    let html = report(&facts, &results, &summary, None).to_html();
    for text in [
        "a &lt;case&gt;",
        "mode 3 diverged. Halve --dt.",
        "Angular velocity of A",
        "Side view",
        "Displacement of P in A",
        "Modal amplitudes",
        "Linear momentum",
        "romrun frame.rom --loads lc",
    ] {
        assert!(html.contains(text), "{text}");
    }
}
