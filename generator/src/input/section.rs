//! Cross-sections: from shapes and materials to the 6x6 stiffness and mass of theory section 1.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector6};

use super::file::{Circle, Constants, Material, Matrix, Rectangle, SectionFile, Tube};
use super::read::Reader;
use super::values::{Named, Number, Square, Text, positive};
use crate::mesh::Section;

/// Entries of a symmetric matrix may differ by this much of the geometric mean of their diagonal entries.
const ASYMMETRY: f64 = 1e-9;

/// Smallest eigenvalue of a definite matrix scaled to unit diagonal: below it nothing but round-off is left.
const SMALLEST_EIGENVALUE: f64 = 1e-12;

/// Checks all sections and materials, used or not; `None` where one is wrong.
pub(crate) fn resolve_sections(
    materials: &Named<Material>,
    sections: &Named<SectionFile>,
    reader: &mut Reader,
) -> Vec<Option<Section>> {
    let good: Vec<Option<Isotropic>> =
        materials.items.iter().map(|(_, m)| Isotropic::check(m.as_ref()?, reader)).collect();
    let find = |name: &Text, reader: &mut Reader| {
        materials.find(name, "material", "materials", reader).and_then(|index| good[index])
    };
    let one = |(name, section): &(Text, Option<SectionFile>)| {
        let section = section.as_ref()?;
        let (stiffness, mass) = match section {
            SectionFile::Rectangle(r) => rectangle(r, find(&r.material, reader), reader)?,
            SectionFile::Circle(c) => circle(c, find(&c.material, reader), reader)?,
            SectionFile::Tube(t) => tube(t, find(&t.material, reader), reader)?,
            SectionFile::Constants(c) => constants(c, reader)?,
            SectionFile::Matrix(m) => matrices(m, reader)?,
        };
        let sound = [stiffness, mass].iter().all(|m| m.diagonal().iter().all(|d| d.is_normal() && *d > 0.0));
        if !sound {
            let message = format!("section `{}` is too small or too large to compute with", name.value);
            return reader.error(name.span, message);
        }
        Some(Section { name: name.value.clone(), stiffness, mass })
    };
    sections.items.iter().map(one).collect()
}

#[derive(Clone, Copy)]
struct Isotropic {
    young: f64,
    shear: f64,
    nu: f64,
    rho: f64,
}

impl Isotropic {
    fn check(m: &Material, reader: &mut Reader) -> Option<Self> {
        let young = positive(&m.E, "Young's modulus", "Pa", reader);
        let rho = positive(&m.rho, "the density", "kg/m^3", reader);
        let nu = m.nu.value;
        if !(nu > -1.0 && nu < 0.5) {
            return reader.error(
                m.nu.span,
                format!("Poisson's ratio is {nu}, expected a number above -1 and below 0.5"),
            );
        }
        let young = young?;
        Some(Self { young, shear: young / (2.0 * (1.0 + nu)), nu, rho: rho? })
    }
}

/// Area, second moments about local y and z, torsion constant and shear factors.
struct Shape {
    area: f64,
    second: [f64; 2],
    torsion: f64,
    shear: [f64; 2],
}

impl Shape {
    fn matrices(&self, m: Isotropic) -> (Matrix6<f64>, Matrix6<f64>) {
        let [iy, iz] = self.second;
        let ga = m.shear * self.area;
        let stiffness = Vector6::new(
            m.young * self.area,
            self.shear[0] * ga,
            self.shear[1] * ga,
            m.shear * self.torsion,
            m.young * iy,
            m.young * iz,
        );
        let line = m.rho * self.area;
        let mass = Vector6::new(line, line, line, m.rho * (iy + iz), m.rho * iy, m.rho * iz);
        (Matrix6::from_diagonal(&stiffness), Matrix6::from_diagonal(&mass))
    }
}

type Pair = (Matrix6<f64>, Matrix6<f64>);

fn factors(given: &Option<[Number; 2]>, default: f64, reader: &mut Reader) -> Option<[f64; 2]> {
    let Some(given) = given else { return Some([default; 2]) };
    let [y, z] = given.each_ref().map(|k| positive(k, "the shear factor", "", reader));
    Some([y?, z?])
}

fn torsion(given: &Option<Number>, default: f64, reader: &mut Reader) -> Option<f64> {
    match given {
        Some(given) => positive(given, "the torsion constant", "m^4", reader),
        None => Some(default),
    }
}

fn rectangle(r: &Rectangle, material: Option<Isotropic>, reader: &mut Reader) -> Option<Pair> {
    let b = positive(&r.width_y, "the width", "m", reader);
    let h = positive(&r.width_z, "the width", "m", reader);
    let shear = factors(&r.shear_factors, 5.0 / 6.0, reader);
    let given = torsion(&r.torsion_constant, f64::NAN, reader);
    let (b, h) = (b?, h?);
    let torsion = if r.torsion_constant.is_some() { given? } else { rectangle_torsion(b, h) };
    let area = b * h;
    let second = [area * h * h / 12.0, area * b * b / 12.0];
    Some(Shape { area, second, torsion, shear: shear? }.matrices(material?))
}

/// Saint-Venant's torsion constant of a rectangle with sides `b` and `h`, m^4: for the longer side `a` and the shorter
/// `c`, `J = a c^3 (1/3 - 64/pi^5 c/a sum over odd n of tanh(n pi a / 2c) / n^5)` (Timoshenko & Goodier, Theory of
/// Elasticity, art. 109).
fn rectangle_torsion(b: f64, h: f64) -> f64 {
    let (a, c) = (b.max(h), b.min(h));
    // Terms fall like n^-5: the rest beyond n = 2001 is below 1e-14 of the sum.
    let sum: f64 = (0..=1000)
        .rev()
        .map(|k| f64::from(2 * k + 1))
        .map(|n| (n * PI * a / (2.0 * c)).tanh() / n.powi(5))
        .sum();
    a * c.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * c / a * sum)
}

fn circle(c: &Circle, material: Option<Isotropic>, reader: &mut Reader) -> Option<Pair> {
    let d = positive(&c.diameter, "the diameter", "m", reader);
    let (d, material) = (d?, material?);
    ring(d, 0.0, (&c.shear_factors, &c.torsion_constant), material, reader)
}

fn tube(t: &Tube, material: Option<Isotropic>, reader: &mut Reader) -> Option<Pair> {
    let d = positive(&t.outer_diameter, "the diameter", "m", reader);
    let wall = positive(&t.wall_thickness, "the wall thickness", "m", reader);
    let (d, wall) = (d?, wall?);
    if wall >= d / 2.0 {
        let message =
            format!("the wall thickness is {wall} m, expected less than half the diameter of {d} m");
        return reader.error_help(t.wall_thickness.span, message, "a solid section has shape = \"circle\"");
    }
    ring(d, d - 2.0 * wall, (&t.shear_factors, &t.torsion_constant), material?, reader)
}

/// Hollow circle of outer diameter `d` and inner `d_in`; shear factor of G. R. Cowper, "The shear coefficient in
/// Timoshenko's beam theory", J. Appl. Mech. 33 (1966), which for `d_in = 0` is that of the full circle.
fn ring(
    d: f64,
    d_in: f64,
    (shear, torsion_constant): (&Option<[Number; 2]>, &Option<Number>),
    material: Isotropic,
    reader: &mut Reader,
) -> Option<Pair> {
    let area = PI / 4.0 * (d - d_in) * (d + d_in);
    let second = area * (d * d + d_in * d_in) / 16.0;
    let (nu, m2) = (material.nu, (d_in / d).powi(2));
    let q = (1.0 + m2).powi(2);
    let cowper = 6.0 * (1.0 + nu) * q / ((7.0 + 6.0 * nu) * q + (20.0 + 12.0 * nu) * m2);
    let shear = factors(shear, cowper, reader);
    let torsion = torsion(torsion_constant, 2.0 * second, reader);
    Some(Shape { area, second: [second; 2], torsion: torsion?, shear: shear? }.matrices(material))
}

fn constants(c: &Constants, reader: &mut Reader) -> Option<Pair> {
    let stiffness = [
        positive(&c.EA, "EA", "N", reader),
        positive(&c.GAy, "GAy", "N", reader),
        positive(&c.GAz, "GAz", "N", reader),
        positive(&c.GJ, "GJ", "N m^2", reader),
        positive(&c.EIy, "EIy", "N m^2", reader),
        positive(&c.EIz, "EIz", "N m^2", reader),
    ];
    let line = positive(&c.rhoA, "rhoA", "kg/m", reader);
    let j = c.rhoJ.value;
    if j.min() <= 0.0 {
        let message = format!("rhoJ is ({}, {}, {}) kg m, expected three positive numbers", j.x, j.y, j.z);
        return reader.error(c.rhoJ.span, message);
    }
    let [ea, gay, gaz, gj, eiy, eiz] = stiffness;
    let line = line?;
    let stiffness = Vector6::new(ea?, gay?, gaz?, gj?, eiy?, eiz?);
    let mass = Vector6::new(line, line, line, j.x, j.y, j.z);
    Some((Matrix6::from_diagonal(&stiffness), Matrix6::from_diagonal(&mass)))
}

fn matrices(m: &Matrix, reader: &mut Reader) -> Option<Pair> {
    let stiffness = positive_definite(&m.stiffness, "the stiffness", reader);
    let mass = positive_definite(&m.mass, "the mass matrix", reader);
    let mass = mass.and_then(|mass| mass_of_a_section(&mass, &m.mass, reader));
    Some((stiffness?, mass?))
}

/// The mass matrix of a section is `[[m I, -m c~], [m c~, J]]`, with the mass centre at `c`: were it not, force would not
/// be the rate of momentum of anything.
fn mass_of_a_section(mass: &Matrix6<f64>, given: &Square<6>, reader: &mut Reader) -> Option<Matrix6<f64>> {
    let m = mass[(0, 0)];
    let block = mass.fixed_view::<3, 3>(0, 3);
    let skew = (block - block.transpose()) * 0.5;
    let mut expected = *mass;
    expected.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * m));
    expected.fixed_view_mut::<3, 3>(0, 3).copy_from(&skew);
    expected.fixed_view_mut::<3, 3>(3, 0).copy_from(&skew.transpose());
    for (i, j) in (0..3).flat_map(|i| (0..6).map(move |j| (i, j))) {
        let scale = (m * mass[(j, j)]).sqrt();
        if (mass[(i, j)] - expected[(i, j)]).abs() > ASYMMETRY * scale {
            let message = format!(
                "the mass matrix is that of no section: row {}, column {} is {}, expected {}",
                i + 1,
                j + 1,
                mass[(i, j)],
                expected[(i, j)]
            );
            let help =
                "it has the form [[m I, -m c~], [m c~, J]], with m the mass per length and c the mass centre";
            return reader.error_help(given.entries[i * 6 + j], message, help);
        }
    }
    Some(expected)
}

/// The symmetric part of a matrix that must be symmetric; the scale of entry i, j is that of the diagonal.
pub(crate) fn symmetric<const N: usize>(
    m: &Square<N>,
    what: &str,
    reader: &mut Reader,
) -> Option<SMatrix<f64, N, N>> {
    let a = m.value.as_ref();
    let scale = |i: usize, j: usize| {
        let diagonal = (a[(i, i)].abs() * a[(j, j)].abs()).sqrt();
        diagonal.max(a[(i, j)].abs()).max(a[(j, i)].abs())
    };
    for i in 0..N {
        for j in 0..i {
            let (lower, upper) = (a[(i, j)], a[(j, i)]);
            if (lower - upper).abs() > ASYMMETRY * scale(i, j) {
                let (i1, j1) = (i + 1, j + 1);
                let message = format!(
                    "{what} is not symmetric: row {i1}, column {j1} is {lower}, but row {j1}, column {i1} is {upper}"
                );
                return reader.error(m.entries[i * N + j], message);
            }
        }
    }
    Some((a + a.transpose()) * 0.5)
}

/// Checks a 6x6 matrix. Its entries have different units, so definiteness is judged after scaling to unit diagonal.
fn positive_definite(m: &Square<6>, what: &str, reader: &mut Reader) -> Option<Matrix6<f64>> {
    let a = symmetric(m, what, reader)?;
    for i in 0..6 {
        if a[(i, i)] <= 0.0 {
            let message =
                format!("{what} is not positive definite: diagonal entry {} is {}", i + 1, a[(i, i)]);
            return reader.error(m.entries[i * 7], message);
        }
    }
    let scaled = Matrix6::from_fn(|i, j| a[(i, j)] / (a[(i, i)].sqrt() * a[(j, j)].sqrt()));
    let smallest = scaled.symmetric_eigenvalues().min();
    if smallest > SMALLEST_EIGENVALUE {
        return Some(a);
    }
    let message = format!(
        "{what} is not positive definite: scaled to unit diagonal, its smallest eigenvalue is {smallest:.3e}"
    );
    let help = format!(
        "the eigenvalues must be above {SMALLEST_EIGENVALUE:e}; check the signs of the coupling terms"
    );
    reader.error_help(m.span, message, help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Timoshenko & Goodier's table of J / (a c^3) over a / c.
    #[test]
    fn rectangle_torsion_constant() {
        for (ratio, k) in
            [(1.0, 0.1406), (1.2, 0.166), (1.5, 0.196), (2.0, 0.229), (5.0, 0.291), (10.0, 0.312)]
        {
            assert_relative_eq!(rectangle_torsion(ratio, 1.0), k * ratio, max_relative = 4e-3);
        }
        assert_eq!(rectangle_torsion(0.3, 0.1), rectangle_torsion(0.1, 0.3));
        assert_relative_eq!(rectangle_torsion(1.0, 1.0), 0.140_577_014_955, max_relative = 1e-10);
    }
}
