//! Every array of a model as a NumPy archive, for other languages.

use std::io::{self, Seek, Write};
use std::path::Path;

use npyz::npz::NpzWriter;
use rom_runtime::data::{LagrangianData, ModelData, PictureData, PointData, PolynomialData, TensorData};
use serde_json::json;

use crate::atomic;
use crate::results::write_array;

/// Writes all arrays of the model by name. `M`, `D` and `K` are the full reduced matrices of the linear part,
/// `M u' + D u + K (q, 0) = ...` with `u = (q', beta*)`; `c` and `k` are in coordinate form, sorted by index; `metadata`
/// is a JSON text as bytes (uint8) with everything that is not an array.
///
/// # Errors
/// Those of the file system, naming the file.
pub fn write_npz(data: &ModelData, path: &Path) -> io::Result<()> {
    atomic::write(path, |sink| {
        let mut out = Out { archive: NpzWriter::new(sink) };
        reduced_matrices(&mut out, data)?;
        modes(&mut out, data)?;
        rigid(&mut out, data)?;
        tensor(&mut out, "c", &data.c)?;
        tensor(&mut out, "k", &data.k)?;
        for point in &data.points {
            self::point(&mut out, point, data.modes.omega.len() as u64)?;
        }
        if let Some(picture) = &data.picture {
            self::picture(&mut out, picture, data.modes.omega.len() as u64)?;
        }
        if let (Some(curve), Some(picture)) = (&data.picture_curve, &data.picture) {
            let nodes = picture.positions.len() as u64 / 3;
            let k = (curve.shapes.len() as u64).checked_div(3 * nodes).unwrap_or(0);
            out.floats("picture.curve.shapes", &[nodes, 3, k], &curve.shapes)?;
        }
        if let Some(trim) = &data.trim {
            out.floats("trim.elastic_force", &[trim.elastic_force.len() as u64], &trim.elastic_force)?;
            out.floats("trim.elastic_energy", &[], &[trim.elastic_energy])?;
            out.floats("trim.attitude", &[4], &trim.attitude)?;
            out.floats("trim.reaction", &[6], &trim.reaction)?;
        }
        if let Some(gravity) = &data.gravity {
            let m = if gravity.second_moment.is_empty() { 0 } else { data.modes.omega.len() as u64 };
            out.floats("gravity.acceleration", &[3], &gravity.acceleration)?;
            out.floats("gravity.second_moment", &[3, m, m], &gravity.second_moment)?;
        }
        if let Some(lagrangian) = &data.lagrangian {
            self::lagrangian(&mut out, lagrangian, data.modes.omega.len() as u64)?;
        }
        metadata(&mut out, data)?;
        out.archive.zip_writer().finish()?;
        Ok(())
    })
}

struct Out<W: Write + Seek> {
    archive: NpzWriter<W>,
}

impl<W: Write + Seek> Out<W> {
    fn floats(&mut self, name: &str, shape: &[u64], values: &[f64]) -> io::Result<()> {
        write_array(&mut self.archive, name, shape, values)
    }

    fn integers(&mut self, name: &str, values: &[u32]) -> io::Result<()> {
        write_array(&mut self.archive, name, &[values.len() as u64], values)
    }
}

/// Elastic modes are orthogonal to each other and to the rigid ones: diagonal, with `M_RR` in the corner of `M`; damping may couple them.
fn reduced_matrices<W: Write + Seek>(out: &mut Out<W>, data: &ModelData) -> io::Result<()> {
    let m = data.modes.omega.len();
    let n = m + 6;
    let diagonal = |value: &dyn Fn(usize) -> f64| {
        let mut matrix = vec![0.0; n * n];
        (0..m).for_each(|i| matrix[i * n + i] = value(i));
        matrix
    };
    let (mass, omega, ratio) = (&data.modes.mass, &data.modes.omega, &data.modes.damping_ratio);
    let mut full_mass = diagonal(&|i| mass[i]);
    for i in 0..6 {
        let row = (m + i) * n + m;
        full_mass[row..row + 6].copy_from_slice(&data.rigid.mass_matrix[6 * i..6 * i + 6]);
    }
    let shape = [n as u64, n as u64];
    out.floats("M", &shape, &full_mass)?;
    let mut damping = diagonal(&|i| 2.0 * ratio[i] * omega[i] * mass[i]);
    if let Some(coupled) = &data.damping {
        for (index, value) in coupled.coupling.iter().enumerate() {
            damping[index / m * n + index % m] += value;
        }
    }
    out.floats("D", &shape, &damping)?;
    out.floats("K", &shape, &diagonal(&|i| omega[i] * omega[i] * mass[i]))
}

fn modes<W: Write + Seek>(out: &mut Out<W>, data: &ModelData) -> io::Result<()> {
    let modes = &data.modes;
    let m = modes.omega.len() as u64;
    out.integers("modes.number", &modes.number)?;
    out.floats("modes.omega", &[m], &modes.omega)?;
    out.floats("modes.mass", &[m], &modes.mass)?;
    out.floats("modes.damping_ratio", &[m], &modes.damping_ratio)?;
    out.floats("modes.phi_r", &[6, m], &modes.phi_r)?;
    out.floats("modes.kinetic_share", &[m, 6], &modes.kinetic_share)?;
    out.floats("modes.first_moment", &[3, m], &modes.first_moment)
}

fn rigid<W: Write + Seek>(out: &mut Out<W>, data: &ModelData) -> io::Result<()> {
    let rigid = &data.rigid;
    out.floats("rigid.mass", &[], &[rigid.mass])?;
    out.floats("rigid.centre_of_mass", &[3], &rigid.centre_of_mass)?;
    out.floats("rigid.mass_matrix", &[6, 6], &rigid.mass_matrix)?;
    out.floats("rigid.initial_position", &[3], &rigid.initial_position)
}

/// The Lagrangian of a consistent model, in the symbols of docs/beyond.md.
fn lagrangian<W: Write + Seek>(out: &mut Out<W>, data: &LagrangianData, m: u64) -> io::Result<()> {
    let n = u64::from(data.fields);
    out.floats("lagrangian.linear", &[m, m], &data.linear)?;
    polynomial(out, "lagrangian.curve", &data.curve)?;
    out.floats("lagrangian.first_moment", &[3, n], &data.first_moment)?;
    out.floats("lagrangian.moment_0", &[n, 3, 3], &data.moment_0)?;
    out.integers("lagrangian.moment.a", &data.moment.i)?;
    out.integers("lagrangian.moment.b", &data.moment.l)?;
    out.integers("lagrangian.moment.component", &data.moment.r)?;
    out.floats("lagrangian.moment.value", &[data.moment.value.len() as u64], &data.moment.value)?;
    out.floats("lagrangian.stiffness", &[m, m], &data.stiffness)?;
    out.floats("lagrangian.self_stress", &[data.self_stress.len() as u64], &data.self_stress)?;
    polynomial(out, "lagrangian.self_stress_curve", &data.self_stress_curve)?;
    out.floats("lagrangian.range", &[m], &data.range)?;
    out.floats("lagrangian.tolerance", &[], &[data.tolerance])?;
    out.floats("lagrangian.dropped_norm", &[], &[data.dropped_norm])
}

/// `name.quadratic.row`, `.factors` (two of each term in turn), `.value`; the same for `cubic`.
fn polynomial<W: Write + Seek>(out: &mut Out<W>, name: &str, data: &PolynomialData) -> io::Result<()> {
    terms(out, &format!("{name}.quadratic"), &data.quadratic)?;
    terms(out, &format!("{name}.cubic"), &data.cubic)
}

fn terms<W: Write + Seek, const N: usize>(
    out: &mut Out<W>,
    name: &str,
    terms: &[(u32, [u32; N], f64)],
) -> io::Result<()> {
    let rows: Vec<u32> = terms.iter().map(|term| term.0).collect();
    let factors: Vec<u32> = terms.iter().flat_map(|term| term.1).collect();
    let values: Vec<f64> = terms.iter().map(|term| term.2).collect();
    out.integers(&format!("{name}.row"), &rows)?;
    write_array(&mut out.archive, &format!("{name}.factors"), &[terms.len() as u64, N as u64], &factors)?;
    out.floats(&format!("{name}.value"), &[values.len() as u64], &values)
}

/// `name.i`, `name.l`, `name.r` (and `name.s` for the quadratic one), `name.value`.
fn tensor<W: Write + Seek>(out: &mut Out<W>, name: &str, tensor: &TensorData) -> io::Result<()> {
    out.integers(&format!("{name}.i"), &tensor.i)?;
    out.integers(&format!("{name}.l"), &tensor.l)?;
    if name == "k" {
        // Stored as one code r * 6 + s with r <= s.
        let split = |part: fn(u32) -> u32| tensor.r.iter().map(|&code| part(code)).collect::<Vec<u32>>();
        out.integers("k.r", &split(|code| code / 6))?;
        out.integers("k.s", &split(|code| code % 6))?;
    } else {
        out.integers(&format!("{name}.r"), &tensor.r)?;
    }
    out.floats(&format!("{name}.value"), &[tensor.value.len() as u64], &tensor.value)
}

fn point<W: Write + Seek>(out: &mut Out<W>, point: &PointData, m: u64) -> io::Result<()> {
    let name = |what: &str| format!("points.{}.{what}", point.name);
    out.floats(&name("node_position"), &[3], &point.node_position)?;
    out.floats(&name("node_rotation"), &[4], &point.node_rotation)?;
    out.floats(&name("offset"), &[3], &point.offset)?;
    out.floats(&name("phi_translation"), &[3, m], &point.phi_translation)?;
    out.floats(&name("phi_rotation"), &[3, m], &point.phi_rotation)?;
    for (member, frame) in &point.sections {
        out.floats(&name(&format!("section.{member}")), &[3, 3], frame.as_flattened())?;
    }
    Ok(())
}

fn picture<W: Write + Seek>(out: &mut Out<W>, picture: &PictureData, m: u64) -> io::Result<()> {
    let nodes = picture.positions.len() as u64 / 3;
    out.floats("picture.positions", &[nodes, 3], &picture.positions)?;
    out.floats("picture.phi_translation", &[nodes, 3, m], &picture.phi_translation)?;
    for (i, line) in picture.lines.iter().enumerate() {
        out.integers(&format!("picture.line.{i}"), line)?;
    }
    Ok(())
}

fn metadata<W: Write + Seek>(out: &mut Out<W>, data: &ModelData) -> io::Result<()> {
    let dropped = |t: &TensorData| {
        json!({
            "threshold": t.threshold, "scale": t.scale, "dropped_norm": t.dropped_norm, "dropped_count": t.dropped_count
        })
    };
    let text = serde_json::to_vec(&json!({
        "provenance": data.provenance,
        "points": data.points.iter().map(|p| &p.name).collect::<Vec<_>>(),
        "load_cases": data.load_cases,
        "trim_loads": data.trim.as_ref().map(|trim| &trim.loads),
        "checks": data.checks,
        "next_omega": data.modes.next_omega,
        "c": dropped(&data.c),
        "k": dropped(&data.k),
    }))?;
    write_array(&mut out.archive, "metadata", &[text.len() as u64], &text)
}

#[cfg(test)]
mod tests {
    use npyz::npz::NpzArchive;

    use super::*;

    #[test]
    fn every_array_comes_back_in_its_shape() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.npz");
        let data = crate::info::sample();
        write_npz(&data, &path).unwrap();
        let mut archive = NpzArchive::open(&path).unwrap();
        let mut get = |name: &str| {
            let array = archive.by_name(name).unwrap().unwrap_or_else(|| panic!("no {name}"));
            (array.shape().to_vec(), array.into_vec::<f64>().unwrap())
        };
        let (shape, mass) = get("M");
        assert_eq!(shape, [8, 8]);
        assert_eq!((mass[0], mass[9], mass[2 * 8 + 2], mass[7 * 8 + 7], mass[1]), (1.0, 1.0, 4.0, 9.0, 0.0));
        assert_eq!(get("K").1[9], data.modes.omega[1] * data.modes.omega[1]);
        assert_eq!(get("D").1[9], 2.0 * 0.01 * data.modes.omega[1]);
        assert_eq!(get("modes.phi_r").0, [6, 2]);
        assert_eq!(get("rigid.mass"), (vec![], vec![4.0]));
        assert_eq!(get("points.P.phi_rotation"), (vec![3, 2], data.points[0].phi_rotation.clone()));
        assert_eq!(get("c.value").1, data.c.value);
        let mut integers = |name: &str| archive.by_name(name).unwrap().unwrap().into_vec::<u32>().unwrap();
        assert_eq!((integers("k.r"), integers("k.s")), (vec![4, 5, 1], vec![4, 5, 1]));
    }
}
