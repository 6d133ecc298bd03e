//! Solid shapes of one material: the 6x6 stiffness and mass of their sections, also between two of them.

use std::f64::consts::PI;

use nalgebra::{Matrix6, Vector6};

use super::Section;

/// An isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Isotropic {
    pub young: f64,
    pub nu: f64,
    pub rho: f64,
}

/// Outline of a section, m.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outline {
    /// Sizes along local y and z.
    Rectangle([f64; 2]),
    Circle {
        diameter: f64,
    },
    Tube {
        diameter: f64,
        wall: f64,
    },
}

/// A section given by its outline, and by what its author knows better than the formulas.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub outline: Outline,
    pub material: Isotropic,
    /// Shear factors `k_y`, `k_z`.
    pub shear_factors: Option<[f64; 2]>,
    /// Torsion constant `J`, m^4.
    pub torsion_constant: Option<f64>,
}

/// A section of the input: its matrices, and the shape they come from, if any.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pub section: Section,
    pub shape: Option<Shape>,
}

impl Profile {
    /// The section at `x` from 0 (here) to 1 (`other`). Sizes are interpolated between shapes of one kind and material, the matrices
    /// otherwise.
    pub(crate) fn between(&self, other: &Self, x: f64) -> Section {
        let name = format!("{} to {} at {x:.4}", self.section.name, other.section.name);
        let shape = self.shape.zip(other.shape).and_then(|(a, b)| a.between(&b, x));
        let (stiffness, mass) = shape.map_or_else(
            || {
                let mean = |a: &Matrix6<f64>, b: &Matrix6<f64>| a * (1.0 - x) + b * x;
                let (a, b) = (&self.section, &other.section);
                (mean(&a.stiffness, &b.stiffness), mean(&a.mass, &b.mass))
            },
            |shape| shape.matrices(),
        );
        let retardation = self.section.retardation * (1.0 - x) + other.section.retardation * x;
        Section { name, stiffness, mass, retardation }
    }
}

/// Area, second moments about local y and z, torsion constant and shear factors.
struct Properties {
    area: f64,
    second: [f64; 2],
    torsion: f64,
    shear: [f64; 2],
}

impl Shape {
    /// Sizes linear between; `None` where the two are not of one kind.
    fn between(&self, other: &Self, x: f64) -> Option<Self> {
        let mean = |a: f64, b: f64| a * (1.0 - x) + b * x;
        let pair = |a: [f64; 2], b: [f64; 2]| [mean(a[0], b[0]), mean(a[1], b[1])];
        if self.material != other.material
            || self.shear_factors.is_some() != other.shear_factors.is_some()
            || self.torsion_constant.is_some() != other.torsion_constant.is_some()
        {
            return None;
        }
        let outline = match (self.outline, other.outline) {
            (Outline::Rectangle(a), Outline::Rectangle(b)) => Outline::Rectangle(pair(a, b)),
            (Outline::Circle { diameter: a }, Outline::Circle { diameter: b }) => {
                Outline::Circle { diameter: mean(a, b) }
            }
            (Outline::Tube { diameter: a, wall: s }, Outline::Tube { diameter: b, wall: t }) => {
                Outline::Tube { diameter: mean(a, b), wall: mean(s, t) }
            }
            _ => return None,
        };
        Some(Self {
            outline,
            material: self.material,
            shear_factors: self.shear_factors.zip(other.shear_factors).map(|(a, b)| pair(a, b)),
            torsion_constant: self.torsion_constant.zip(other.torsion_constant).map(|(a, b)| mean(a, b)),
        })
    }

    /// 6x6 stiffness and mass.
    pub(crate) fn matrices(&self) -> (Matrix6<f64>, Matrix6<f64>) {
        let Properties { area, second: [iy, iz], torsion, shear } = self.properties();
        let Isotropic { young, nu, rho } = self.material;
        let g = young / (2.0 * (1.0 + nu));
        let ga = g * area;
        let stiffness =
            Vector6::new(young * area, shear[0] * ga, shear[1] * ga, g * torsion, young * iy, young * iz);
        let line = rho * area;
        let mass = Vector6::new(line, line, line, rho * (iy + iz), rho * iy, rho * iz);
        (Matrix6::from_diagonal(&stiffness), Matrix6::from_diagonal(&mass))
    }

    fn properties(&self) -> Properties {
        let by_formula = match self.outline {
            Outline::Rectangle([b, h]) => Properties {
                area: b * h,
                second: [b * h * h * h / 12.0, h * b * b * b / 12.0],
                torsion: if self.torsion_constant.is_some() { 0.0 } else { rectangle_torsion(b, h) },
                shear: [5.0 / 6.0; 2],
            },
            Outline::Circle { diameter } => ring(diameter, 0.0, self.material.nu),
            Outline::Tube { diameter, wall } => ring(diameter, diameter - 2.0 * wall, self.material.nu),
        };
        Properties {
            torsion: self.torsion_constant.unwrap_or(by_formula.torsion),
            shear: self.shear_factors.unwrap_or(by_formula.shear),
            ..by_formula
        }
    }
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

/// Hollow circle of outer diameter `d` and inner `d_in`; shear factor of G. R. Cowper, "The shear coefficient in
/// Timoshenko's beam theory", J. Appl. Mech. 33 (1966), which for `d_in = 0` is that of the full circle.
fn ring(d: f64, d_in: f64, nu: f64) -> Properties {
    let area = PI / 4.0 * (d - d_in) * (d + d_in);
    let second = area * (d * d + d_in * d_in) / 16.0;
    let m2 = (d_in / d).powi(2);
    let q = (1.0 + m2).powi(2);
    let cowper = 6.0 * (1.0 + nu) * q / ((7.0 + 6.0 * nu) * q + (20.0 + 12.0 * nu) * m2);
    Properties { area, second: [second; 2], torsion: 2.0 * second, shear: [cowper; 2] }
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
