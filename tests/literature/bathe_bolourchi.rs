//! Bend of 45 degrees and radius 100, section 1 x 1, E = 1e7, nu = 0, under a force out of its plane: K.-J. Bathe and S. Bolourchi,
//! "Large displacement analysis of three-dimensional beam structures", Int. J. Numer. Methods Engrg. 14 (1979).
//!
//! Tip displacement under 600, published: (-13.4, -23.5, 53.4) by Bathe and Bolourchi with eight straight elements;
//! (-13.5, -23.7, 53.4) by BeamDyn (Wang, Sprague, Jonkman and Johnson, NREL/CP-5000-63165, 2015) with the section constants below
//! (torsion by the polar moment). Other codes lie between (-13.8, -23.9, 53.7) and (-13.4, -23.4, 53.4). Ours, converged and the
//! same by two kinds of elements: (-13.605, -23.561, 53.475).

use super::{assert_near, displacement, equilibrium, mesh};
use nalgebra::Vector3;

fn tip(elements: usize, element_nodes: usize) -> Vector3<f64> {
    let mesh = mesh(&format!(
        r#"
        [structure]
        name = "bend"
        reference = "root"
        element_nodes = {element_nodes}
        [sections.square]
        shape = "constants"
        EA = 1e7
        GAy = "5e6 * 5 / 6"
        GAz = "5e6 * 5 / 6"
        GJ = "5e6 / 6"
        EIy = "1e7 / 12"
        EIz = "1e7 / 12"
        rhoA = 1
        rhoJ = ["1 / 6", "1 / 12", "1 / 12"]
        [points]
        root = [0, 0, 0]
        tip = ["100 * (1 - cos(45*deg))", "100 * sin(45*deg)", 0]
        [[members]]
        name = "bend"
        arc = {{ from = "root", to = "tip", center = [100, 0, 0] }}
        section = "square"
        elements = {elements}
        local_y = [0, 0, 1]
        [load_cases.tip]
        t_end = 1
        dt = 1
        loads = [{{ point = "tip", frame = "dead", force = [0, 0, 600] }}]
        "#
    ));
    displacement(&mesh, &equilibrium(&mesh), "tip")
}

#[test]
fn tip_displacement() {
    // Linear elements, second order: Richardson from 32 and 64. Quadratic ones, fourth order: 16 are converged.
    let (coarse, fine) = (tip(32, 2), tip(64, 2));
    let linear = fine + (fine - coarse) / 3.0;
    let quadratic = tip(16, 3);
    println!("converged tip displacement {quadratic:?}, linear {linear:?}");
    assert!((linear - quadratic).norm() < 2e-4, "{linear} {quadratic}");
    assert!((quadratic - Vector3::new(-13.605, -23.561, 53.475)).amax() < 1e-3);
    for (k, (low, high)) in [(-13.8, -13.4), (-23.9, -23.4), (53.35, 53.75)].into_iter().enumerate() {
        assert!((low..=high).contains(&quadratic[k]), "{quadratic}");
    }
    // Eight linear elements, as in the paper.
    let paper = tip(8, 2);
    for (k, published) in [-13.4, -23.5, 53.4].into_iter().enumerate() {
        assert_near(paper[k], published, 0.3, "eight linear elements");
    }
}
