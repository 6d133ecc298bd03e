//! What is written of a model and of a run.

use std::io;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use rom_runtime::data::{ModelData, PictureData};

use super::grid::{Field, Grid, escape};
use super::sections::Sections;
use crate::atomic;
use crate::results::Results;

/// Frames of a run where nothing else is asked for.
pub const FRAMES: usize = 200;

const NO_PICTURE: &str = "the model file holds no lines for pictures: build it again with this version";

/// Writes the mode shapes of a model on the structure at rest in A: for every mode its displacement in A (`mode 1`) and that of the
/// free body in space (`mode 1 in space`), and on the pieces of the lines its internal loads (`mode 1 internal_force`, `..moment`), per unit
/// modal amplitude.
///
/// # Errors
/// A model file without lines for pictures, and those of the file system.
pub fn write_modes(data: &ModelData, path: &Path) -> io::Result<()> {
    let picture = picture(data)?;
    let m = data.modes.omega.len();
    let n = picture.positions.len() / 3;
    let place = |node: usize| Vector3::from_row_slice(&picture.positions[3 * node..3 * node + 3]);
    let mut fields = Vec::with_capacity(2 * m);
    for (j, number) in data.modes.number.iter().enumerate() {
        let motion = |row: usize| data.modes.phi_r[row * m + j];
        let (v, w) = (Vector3::from_fn(|k, _| motion(k)), Vector3::from_fn(|k, _| motion(3 + k)));
        let relative = |node: usize| Vector3::from_fn(|k, _| picture.phi_translation[(3 * node + k) * m + j]);
        let flat =
            |of: &dyn Fn(usize) -> Vector3<f64>| (0..n).flat_map(|node| <[f64; 3]>::from(of(node))).collect();
        fields.push(Field { name: format!("mode {number}"), values: flat(&relative) });
        let in_space = |node: usize| relative(node) + v + w.cross(&place(node));
        fields.push(Field { name: format!("mode {number} in space"), values: flat(&in_space) });
    }
    let sections = sections(data, picture);
    let mut cell_fields = Vec::new();
    if !sections.is_empty() {
        for (j, number) in data.modes.number.iter().enumerate() {
            let of = |first: usize| {
                move |place: usize| [0, 1, 2].map(|k| data.cuts[place].modal[(first + k) * m + j])
            };
            cell_fields.push(sections.field(&format!("mode {number} internal_force"), of(0)));
            cell_fields.push(sections.field(&format!("mode {number} internal_moment"), of(3)));
        }
    }
    Grid { points: picture.positions.clone(), lines: picture.lines.clone(), fields, cell_fields }.write(path)
}

/// Writes at most `frames` instants of a run into `folder`: `structure.pvd`, which is what to open, and the grids it names in
/// `vtk/`. The points are where the nodes are in G; the fields are the displacement since the equilibrium and the velocity, both
/// with components in G. `data` is that of the reduced model itself, also where a simpler method ran. Returns the path of the
/// collection, which is written last.
///
/// # Errors
/// A model file without lines for pictures, results without the rates of the modes, and those of the file system.
pub fn write_run(data: &ModelData, results: &Results, frames: usize, folder: &Path) -> io::Result<PathBuf> {
    let picture = picture(data)?;
    let grids = folder.join("vtk");
    atomic::make_folder(&grids)?;
    let rows = crate::scene::frames(results.rows(), frames.max(2));
    let collection = folder.join("structure.pvd");
    let digits = rows.len().to_string().len().max(4);
    let name = |k: usize| format!("structure_{k:0digits$}.vtu");
    let sections = sections(data, picture);
    for (k, &row) in rows.iter().enumerate() {
        let mut grid = grid(picture, results, row)?;
        grid.cell_fields = internal_loads(&sections, results, row)?;
        grid.write(&grids.join(name(k)))?;
    }
    let t = channel(results, "t")?;
    atomic::write(&collection, |out| {
        writeln!(out, r#"<?xml version="1.0"?>"#)?;
        writeln!(out, r#"<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">"#)?;
        writeln!(out, "<Collection>")?;
        for (k, &row) in rows.iter().enumerate() {
            let (t, file) = (t.data[row], escape(&name(k)));
            writeln!(out, r#"<DataSet timestep="{t}" part="0" file="vtk/{file}"/>"#)?;
        }
        writeln!(out, "</Collection>\n</VTKFile>")
    })?;
    Ok(collection)
}

/// The structure at one row of the results.
fn grid(picture: &PictureData, results: &Results, row: usize) -> io::Result<Grid> {
    let vector = |name| Ok::<_, io::Error>(Vector3::from_row_slice(channel(results, name)?.row(row)));
    let (r, v, w) = (vector("r_G")?, vector("v_G")?, vector("w_G")?);
    let zeta = channel(results, "zeta")?.row(row);
    let attitude = UnitQuaternion::new_normalize(Quaternion::new(zeta[0], zeta[1], zeta[2], zeta[3]));
    let c: Matrix3<f64> = attitude.to_rotation_matrix().into_inner();
    // The rigid method has neither amplitudes nor rates.
    let amplitudes = |name: &str| results.channel(name).map_or(&[][..], |channel| channel.row(row));
    let (q, rates) = (amplitudes("q"), amplitudes("q_dot"));
    let n = picture.positions.len() / 3;
    let mut grid = Grid { lines: picture.lines.clone(), ..Grid::default() };
    let (mut displacement, mut velocity) = (Vec::with_capacity(3 * n), Vec::with_capacity(3 * n));
    for node in 0..n {
        let rest = Vector3::from_row_slice(&picture.positions[3 * node..3 * node + 3]);
        let m = picture.phi_translation.len() / (3 * n);
        let sum = |q: &[f64]| {
            Vector3::from_fn(|k, _| {
                let phi = &picture.phi_translation[(3 * node + k) * m..];
                phi.iter().zip(q).map(|(phi, q)| phi * q).sum::<f64>()
            })
        };
        let elastic = c * sum(q);
        let arm = c * rest + elastic;
        grid.points.extend((r + arm).iter());
        displacement.extend(elastic.iter());
        velocity.extend((v + w.cross(&arm) + c * sum(rates)).iter());
    }
    let field = |name: &str, values| Field { name: name.to_owned(), values };
    grid.fields = vec![field("displacement", displacement), field("velocity", velocity)];
    Ok(grid)
}

/// Where the model tells internal loads.
fn sections(data: &ModelData, picture: &PictureData) -> Sections {
    Sections::new(&picture.positions, &picture.lines, &data.lines, &data.cuts)
}

/// Internal loads on the lines at one row of the results.
fn internal_loads(sections: &Sections, results: &Results, row: usize) -> io::Result<Vec<Field>> {
    if sections.is_empty() {
        return Ok(Vec::new());
    }
    let of = |what: &str, name: &str| {
        let places = sections.names().iter();
        let values: Vec<[f64; 3]> = places
            .map(|place| {
                let found = channel(results, &format!("{place}.{what}"))?.row(row);
                Ok([found[0], found[1], found[2]])
            })
            .collect::<io::Result<_>>()?;
        Ok::<_, io::Error>(sections.field(name, |place| values[place]))
    };
    Ok(vec![of("F", "internal_force")?, of("M", "internal_moment")?])
}

fn picture(data: &ModelData) -> io::Result<&PictureData> {
    data.picture.as_ref().ok_or_else(|| io::Error::other(NO_PICTURE))
}

fn channel<'a>(results: &'a Results, name: &str) -> io::Result<&'a crate::results::Channel> {
    results.channel(name).ok_or_else(|| io::Error::other(format!("the results have no channel {name}")))
}
