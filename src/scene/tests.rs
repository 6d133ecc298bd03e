use rom_generator::build::ModeSelection;
use rom_generator::input::Structure;
use rom_generator::reference::method::Method;

use super::*;
use crate::published::FRAME;
use crate::results::Results;
use crate::run::TimeGrid;
use crate::validate::Setup;

#[test]
fn frames_are_even_and_hold_both_ends() {
    assert_eq!(frames(3, 10), [0, 1, 2]);
    assert_eq!(frames(0, 10), [0; 0]);
    let kept = frames(1_001, 11);
    assert_eq!((kept.len(), kept[0], kept[10]), (11, 0, 1_000));
    assert!(kept.windows(2).all(|pair| pair[1] - pair[0] == 100));
}

/// The published frame under load case 2 on a coarse mesh: what came out, and its view.
fn filmed(method: Method) -> (Results, Scene) {
    let sets = [("elements", "12"), ("sigma", "10")].map(|(n, v)| (n.to_owned(), v.to_owned()));
    let structure = Structure::from_toml_str(FRAME, "frame", &sets).unwrap();
    let mesh = structure.mesh();
    let case = mesh.load_cases.iter().find(|case| case.name == "lc2").cloned().unwrap();
    let mut setup = Setup::new(structure, mesh, case).unwrap();
    setup.grid = TimeGrid::new(0.02, 2.0, 1).unwrap();
    let modes = ModeSelection::Count(6);
    let (outcome, scene) = setup.run_filmed(method, &modes, "test", true, |_| ()).unwrap();
    let plain = setup.run(method, &modes, "test", |_| ()).unwrap();
    assert_eq!(outcome.results, plain.results, "to be filmed changes nothing");
    (outcome.results, scene.unwrap())
}

/// Where the view draws a node of the structure at frame `i`, in A: the one that rests at `rest`.
fn drawn(scene: &Scene, rest: [f64; 3], i: usize) -> [f64; 3] {
    let body = &scene.bodies[0];
    let k = body.amplitudes.len() / body.t.len();
    let node = (0..scene.positions.len() / 3)
        .find(|n| (0..3).all(|c| (scene.positions[3 * n + c] - rest[c]).abs() < 1e-9))
        .expect("the named point is on a node that is drawn");
    [0, 1, 2].map(|c| {
        let row = 3 * node + c;
        rest[c] + (0..k).map(|j| body.shapes[row * k + j] * body.amplitudes[i * k + j]).sum::<f64>()
    })
}

/// Modes or snapshots: the view shows the motion that the results tell, frame by frame.
#[test]
fn the_view_shows_what_the_results_say() {
    // Rounding for modes; for snapshots the tolerance of their basis.
    for (method, tolerance) in [(Method::Rom, 1e-12), (Method::Nonlinear, 6e-4), (Method::Linear, 6e-4)] {
        let (results, scene) = filmed(method);
        let body = &scene.bodies[0];
        let of = |name: &str| results.channel(name).unwrap();
        assert_eq!(body.t, of("t").data, "as few rows as here are all shown");
        assert_eq!((&body.origin, &body.attitude), (&of("r_G").data, &of("zeta").data));
        let tip = body.points.iter().find(|p| p.name == "P").unwrap();
        let told = &of("P.dR_A").data;
        let largest = told.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(largest > 0.005, "{method}: {largest} m is not much of a test");
        for i in 0..body.t.len() {
            let place = drawn(&scene, tip.rest, i);
            for c in 0..3 {
                let (track, told) = (tip.displacement[3 * i + c], told[3 * i + c]);
                assert!((track - told).abs() <= 1e-12, "{method}: {track} {told}");
                let error = (place[c] - tip.rest[c] - told).abs();
                assert!(error <= tolerance * largest.max(1.0), "{method}, frame {i}: {error}");
            }
        }
    }
}

/// The dead couples of load case 2 keep their directions in G whatever the body does, and their size is the function of time.
#[test]
fn arrows_are_the_loads() {
    for method in [Method::Rom, Method::Nonlinear] {
        let (_, scene) = filmed(method);
        let body = &scene.bodies[0];
        assert!(!body.arrows.is_empty());
        for arrow in &body.arrows {
            assert!(arrow.point < body.points.len());
            let vectors: Vec<[f64; 3]> = arrow.vector.chunks(3).map(|v| [v[0], v[1], v[2]]).collect();
            let last = vectors.last().unwrap();
            let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(length(last) > 0.0);
            for v in &vectors {
                let along = v.iter().zip(last).map(|(a, b)| a * b).sum::<f64>();
                assert!(
                    (along - length(v) * length(last)).abs() <= 1e-12 * length(last).powi(2),
                    "{v:?} {last:?}"
                );
            }
        }
    }
}
