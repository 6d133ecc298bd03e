//! What is written of a model and of a run.

use std::io;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use rom_runtime::data::{CutData, ModelData, PictureData};

use super::grid::{Field, Grid, escape};
use super::sections::{Along, Place, Sections};
use crate::atomic;
use crate::results::Results;
use crate::scene::{Body, Drawn, Scene, Velocity};

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
    let mut drawn = Drawn::of_run(data, results, usize::MAX).ok_or_else(|| io::Error::other(NO_PICTURE))?;
    let rows = crate::scene::frames(results.rows(), frames.max(2));
    let t = channel(results, "t")?;
    let sections = sections(data, picture);
    let times: Vec<f64> = rows.iter().map(|&row| t.data[row]).collect();
    write_frames(folder, &times, &mut |k| {
        let mut grid = grid(&mut drawn, results, rows[k])?;
        grid.cell_fields = internal_loads(&sections, results, rows[k])?;
        Ok(grid)
    })
}

/// Writes at most `frames` instants of what was filmed of a run by any method, as [`write_run`] does: on the points their displacement and velocity, on
/// the lines the internal loads `along` them, by the channels of the results.
///
/// # Errors
/// Results without the channels of the places, and those of the file system.
pub fn write_film(
    scene: &Scene,
    along: &Along,
    results: &Results,
    frames: usize,
    folder: &Path,
) -> io::Result<Option<PathBuf>> {
    let Some(body) = scene.bodies.first() else { return Ok(None) };
    let kept = crate::scene::frames(body.t.len(), frames.max(2));
    let sections = Sections::new(&scene.positions, &scene.lines, along);
    let t = channel(results, "t")?;
    let times: Vec<f64> = kept.iter().map(|&k| body.t[k]).collect();
    write_frames(folder, &times, &mut |k| {
        let mut grid = filmed(scene, body, kept[k]);
        // Films and results count steps alike.
        if let Some(row) = t.data.iter().position(|t| *t == times[k]) {
            grid.cell_fields = internal_loads(&sections, results, row)?;
        }
        Ok(grid)
    })
    .map(Some)
}

/// The grids of all instants and, last, the collection that names them.
fn write_frames(
    folder: &Path,
    times: &[f64],
    grid: &mut dyn FnMut(usize) -> io::Result<Grid>,
) -> io::Result<PathBuf> {
    let grids = folder.join("vtk");
    atomic::make_folder(&grids)?;
    let digits = times.len().to_string().len().max(4);
    let name = |k: usize| format!("structure_{k:0digits$}.vtu");
    for k in 0..times.len() {
        grid(k)?.write(&grids.join(name(k)))?;
    }
    let collection = folder.join("structure.pvd");
    atomic::write(&collection, |out| {
        writeln!(out, r#"<?xml version="1.0"?>"#)?;
        writeln!(out, r#"<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">"#)?;
        writeln!(out, "<Collection>")?;
        for (k, t) in times.iter().enumerate() {
            let file = escape(&name(k));
            writeln!(out, r#"<DataSet timestep="{t}" part="0" file="vtk/{file}"/>"#)?;
        }
        writeln!(out, "</Collection>\n</VTKFile>")
    })?;
    Ok(collection)
}

/// A frame of a film.
fn filmed(scene: &Scene, body: &Body, frame: usize) -> Grid {
    let of_frame = |of: &[f64], n: usize| of.get(n * frame..n * (frame + 1)).unwrap_or(&[]).to_vec();
    let width = body.amplitudes.len() / body.t.len().max(1);
    let at = Placed {
        r: Vector3::from_row_slice(&of_frame(&body.origin, 3)),
        attitude: rotation(&of_frame(&body.attitude, 4)),
        amplitudes: of_frame(&body.amplitudes, width),
        moving: match &body.velocity {
            Velocity::OfShapes { of_a, rates } => {
                let (v, w) = (of_frame(of_a, 6), of_frame(rates, width));
                Some((Vector3::from_row_slice(&v[..3]), Vector3::from_row_slice(&v[3..]), w))
            }
            Velocity::Unknown | Velocity::OfNodes(_) => None,
        },
    };
    let mut grid = at.grid(&scene.positions, &body.shapes, &scene.lines);
    if let Velocity::OfNodes(all) = &body.velocity {
        grid.fields.push(field("velocity", of_frame(all, scene.positions.len())));
    }
    grid
}

/// The structure at one row of the results.
fn grid(drawn: &mut Drawn, results: &Results, row: usize) -> io::Result<Grid> {
    let vector = |name| Ok::<_, io::Error>(Vector3::from_row_slice(channel(results, name)?.row(row)));
    // The rigid method has neither amplitudes nor rates.
    let modal = |name: &str| results.channel(name).map_or(&[][..], |channel| channel.row(row));
    let [amplitudes, rates] = drawn.amplitudes(modal("q"), modal("q_dot"));
    let at = Placed {
        r: vector("r_G")?,
        attitude: rotation(channel(results, "zeta")?.row(row)),
        amplitudes,
        moving: Some((vector("v_G")?, vector("w_G")?, rates)),
    };
    Ok(at.grid(&drawn.positions, &drawn.shapes, &drawn.lines))
}

/// Where A is and how the structure is bent about it, at an instant.
struct Placed {
    /// Origin of A in G, m.
    r: Vector3<f64>,
    /// `C^{GA}`.
    attitude: Matrix3<f64>,
    /// Of the shapes - (width).
    amplitudes: Vec<f64>,
    /// Velocity and angular velocity of A in G, m/s and rad/s, and the rates of the amplitudes - (width); none where they are not known.
    moving: Option<(Vector3<f64>, Vector3<f64>, Vec<f64>)>,
}

impl Placed {
    /// Nodes in G that are at `positions` in A at rest, m - (n x 3), and move in A by `shapes` - (n x 3 x width).
    fn grid(&self, positions: &[f64], shapes: &[f64], lines: &[Vec<u32>]) -> Grid {
        let (n, width) = (positions.len(), self.amplitudes.len());
        let mut grid = Grid { lines: lines.to_vec(), points: Vec::with_capacity(n), ..Grid::default() };
        let (mut displacement, mut velocity) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for (node, rest) in positions.chunks_exact(3).enumerate() {
            let sum = |of_shapes: &[f64]| {
                self.attitude
                    * Vector3::from_fn(|k, _| {
                        let row = width * (3 * node + k);
                        let shapes = shapes.get(row..row + width).unwrap_or(&[]);
                        shapes.iter().zip(of_shapes).map(|(shape, q)| shape * q).sum::<f64>()
                    })
            };
            let elastic = sum(&self.amplitudes);
            let arm = self.attitude * Vector3::from_row_slice(rest) + elastic;
            grid.points.extend((self.r + arm).iter());
            displacement.extend(elastic.iter());
            if let Some((v, w, rates)) = &self.moving {
                velocity.extend((v + w.cross(&arm) + sum(rates)).iter());
            }
        }
        grid.fields = vec![field("displacement", displacement)];
        if self.moving.is_some() {
            grid.fields.push(field("velocity", velocity));
        }
        grid
    }
}

fn rotation(zeta: &[f64]) -> Matrix3<f64> {
    let attitude = UnitQuaternion::new_normalize(Quaternion::new(zeta[0], zeta[1], zeta[2], zeta[3]));
    attitude.to_rotation_matrix().into_inner()
}

fn field(name: &str, values: Vec<f64>) -> Field {
    Field { name: name.to_owned(), values }
}

/// Where the model tells internal loads.
fn sections(data: &ModelData, picture: &PictureData) -> Sections {
    let place = |cut: &CutData| {
        let line = data.lines.iter().position(|line| line.name == cut.member);
        Place { name: cut.name.clone(), line: line.unwrap_or(usize::MAX), fraction: cut.fraction }
    };
    let knots = data.lines.iter().map(|line| line.knots.clone()).collect();
    let along = Along { places: data.cuts.iter().map(place).collect(), knots };
    Sections::new(&picture.positions, &picture.lines, &along)
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
