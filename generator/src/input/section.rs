//! Cross-sections: from shapes and materials to the 6x6 stiffness and mass of theory section 1.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector6};

use super::damping::{Resolved, retardation_time};
use super::file::{Circle, Constants, Material, Matrix, Rectangle, SectionFile, Tube};
use super::read::Reader;
use super::values::{Named, Number, Square, Text, positive};
use crate::mesh::Section;
use crate::mesh::shape::{Isotropic, Outline, Profile, Shape};

/// Entries of a symmetric matrix may differ by this much of the geometric mean of their diagonal entries.
const ASYMMETRY: f64 = 1e-9;

/// Smallest eigenvalue of a definite matrix scaled to unit diagonal: below it nothing but round-off is left.
const SMALLEST_EIGENVALUE: f64 = 1e-12;

/// Checks all sections and materials, used or not; `None` where one is wrong.
pub(crate) fn resolve_sections(
    materials: &Named<Material>,
    sections: &Named<SectionFile>,
    damping: Option<&Resolved>,
    reader: &mut Reader,
) -> Vec<Option<Profile>> {
    let good: Vec<Option<Isotropic>> =
        materials.items.iter().map(|(_, m)| isotropic(m.as_ref()?, reader)).collect();
    let times: Vec<Option<f64>> = materials
        .items
        .iter()
        .map(|(_, m)| retardation_time(m.as_ref()?.retardation_time.as_ref()?, reader))
        .collect();
    let of_material = |name: &Text| materials.names().position(|n| n == name.value).and_then(|i| times[i]);
    let find = |name: &Text, reader: &mut Reader| {
        materials.find(name, "material", "materials", reader).and_then(|index| good[index])
    };
    let shape_of = |section: &SectionFile, reader: &mut Reader| match section {
        SectionFile::Rectangle(r) => {
            let (material, outline) = (find(&r.material, reader), rectangle(r, reader));
            shape(outline, material, &r.shear_factors, &r.torsion_constant, reader)
        }
        SectionFile::Circle(c) => {
            let (material, outline) = (find(&c.material, reader), circle(c, reader));
            shape(outline, material, &c.shear_factors, &c.torsion_constant, reader)
        }
        SectionFile::Tube(t) => {
            let (material, outline) = (find(&t.material, reader), tube(t, reader));
            shape(outline, material, &t.shear_factors, &t.torsion_constant, reader)
        }
        SectionFile::Constants(_) | SectionFile::Matrix(_) => None,
    };
    let one = |(name, section): &(Text, Option<SectionFile>)| {
        let section = section.as_ref()?;
        let shape = shape_of(section, reader);
        let (stiffness, mass) = match section {
            SectionFile::Constants(c) => constants(c, reader)?,
            SectionFile::Matrix(m) => matrices(m, reader)?,
            _ => shape?.matrices(),
        };
        let sound = [stiffness, mass].iter().all(|m| m.diagonal().iter().all(|d| d.is_normal() && *d > 0.0));
        if !sound {
            let message = format!("section `{}` is too small or too large to compute with", name.value);
            return reader.error(name.span, message);
        }
        let own = match section {
            SectionFile::Rectangle(r) => of_material(&r.material),
            SectionFile::Circle(c) => of_material(&c.material),
            SectionFile::Tube(t) => of_material(&t.material),
            SectionFile::Constants(c) => {
                c.retardation_time.as_ref().and_then(|t| retardation_time(t, reader))
            }
            SectionFile::Matrix(m) => m.retardation_time.as_ref().and_then(|t| retardation_time(t, reader)),
        };
        let retardation = damping.map_or(0.0, |d| own.unwrap_or(d.retardation) + d.beta);
        Some(Profile { section: Section { name: name.value.clone(), stiffness, mass, retardation }, shape })
    };
    sections.items.iter().map(one).collect()
}

fn isotropic(m: &Material, reader: &mut Reader) -> Option<Isotropic> {
    let young = positive(&m.E, "Young's modulus", "Pa", reader);
    let rho = positive(&m.rho, "the density", "kg/m^3", reader);
    let nu = m.nu.value;
    if !(nu > -1.0 && nu < 0.5) {
        return reader
            .error(m.nu.span, format!("Poisson's ratio is {nu}, expected a number above -1 and below 0.5"));
    }
    Some(Isotropic { young: young?, nu, rho: rho? })
}

type Pair = (Matrix6<f64>, Matrix6<f64>);

fn shear_factors(given: &Option<[Number; 2]>, reader: &mut Reader) -> Option<Option<[f64; 2]>> {
    let Some(given) = given else { return Some(None) };
    let [y, z] = given.each_ref().map(|k| positive(k, "the shear factor", "", reader));
    Some(Some([y?, z?]))
}

fn torsion_constant(given: &Option<Number>, reader: &mut Reader) -> Option<Option<f64>> {
    let Some(given) = given else { return Some(None) };
    positive(given, "the torsion constant", "m^4", reader).map(Some)
}

fn shape(
    outline: Option<Outline>,
    material: Option<Isotropic>,
    shear: &Option<[Number; 2]>,
    torsion: &Option<Number>,
    reader: &mut Reader,
) -> Option<Shape> {
    let (shear_factors, torsion_constant) = (shear_factors(shear, reader), torsion_constant(torsion, reader));
    Some(Shape {
        outline: outline?,
        material: material?,
        shear_factors: shear_factors?,
        torsion_constant: torsion_constant?,
    })
}

fn rectangle(r: &Rectangle, reader: &mut Reader) -> Option<Outline> {
    let b = positive(&r.width_y, "the width", "m", reader);
    let h = positive(&r.width_z, "the width", "m", reader);
    Some(Outline::Rectangle([b?, h?]))
}

fn circle(c: &Circle, reader: &mut Reader) -> Option<Outline> {
    let diameter = positive(&c.diameter, "the diameter", "m", reader)?;
    Some(Outline::Circle { diameter })
}

fn tube(t: &Tube, reader: &mut Reader) -> Option<Outline> {
    let d = positive(&t.outer_diameter, "the diameter", "m", reader);
    let wall = positive(&t.wall_thickness, "the wall thickness", "m", reader);
    let (diameter, wall) = (d?, wall?);
    if wall >= diameter / 2.0 {
        let message =
            format!("the wall thickness is {wall} m, expected less than half the diameter of {diameter} m");
        return reader.error_help(t.wall_thickness.span, message, "a solid section has shape = \"circle\"");
    }
    Some(Outline::Tube { diameter, wall })
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
