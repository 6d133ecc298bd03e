//! The constant tables of the file.

use std::fmt::Write;

use rom_runtime::data::{ModelData, PointData, StationSet, TensorData};
use rom_runtime::time::TimeFunction;
use rom_runtime::{DistributedLoad, Load, Method, Model, State};

use super::Request;
use super::number::Scalar;
use super::sections;

/// What of a model is written.
pub(super) struct Tables<'a> {
    /// In the form the equations are written in: by the method asked for.
    model: &'a Model,
    /// As in the file, about A.
    source: &'a ModelData,
    scalar: Scalar,
    mean_axes: bool,
    /// Indices into the model's points.
    points: Vec<usize>,
    point_names: Vec<String>,
    sensor_names: Vec<String>,
    /// The points, and after them the stations of the members that carry distributed loads.
    carriers: Vec<Carrier>,
    /// Indices into the model's places of internal loads.
    pub(super) sections: Vec<usize>,
    /// At t = 0.
    start: State,
    /// Loads of the equilibrium and of the load case.
    pub(super) loads: Vec<&'a Load>,
    /// Distributed ones, each with the place of its first station among the carriers.
    pub(super) lines: Vec<(usize, &'a DistributedLoad)>,
}

/// A node that loads act on.
struct Carrier {
    position: [f64; 3],
    quaternion: [f64; 4],
    offset: [f64; 3],
    /// Shapes, a six-vector for each mode.
    phi: Vec<f64>,
    /// Which of the model's points, and of the stations of its lines after them.
    index: usize,
}

impl Carrier {
    fn of_point(point: &PointData, index: usize, m: usize) -> Self {
        let phi = columns(&[(&point.phi_translation, 3), (&point.phi_rotation, 3)], m);
        let (position, quaternion) = (point.node_position, point.node_rotation);
        Carrier { position, quaternion, offset: point.offset, phi, index }
    }

    /// The stations of a line, of which the first is the carrier `first` of the model.
    fn of_stations(set: &StationSet, first: usize, m: usize) -> impl Iterator<Item = Self> + '_ {
        (0..set.len()).map(move |n| {
            let shapes = |all: &'_ [f64]| all[3 * m * n..3 * m * (n + 1)].to_vec();
            let (translation, rotation) = (shapes(&set.phi_translation), shapes(&set.phi_rotation));
            Carrier {
                position: std::array::from_fn(|k| set.position[3 * n + k]),
                quaternion: std::array::from_fn(|k| set.rotation[4 * n + k]),
                offset: [0.0; 3],
                phi: columns(&[(&translation, 3), (&rotation, 3)], m),
                index: first + n,
            }
        })
    }
}

/// Products `u_l beta_r` and `q_l beta_r beta_s`, r <= s, as step.c forms them.
const PAIRS: u32 = 21;

impl<'a> Tables<'a> {
    pub(super) fn new(request: &Request<'a>, model: &'a Model, scalar: Scalar) -> Result<Self, String> {
        let data = model.data();
        let trim = data.trim.iter().flat_map(|trim| &trim.loads);
        let distributed = data.trim.iter().flat_map(|trim| &trim.distributed);
        let distributed: Vec<&DistributedLoad> =
            distributed.chain(request.case.iter().flat_map(|case| &case.distributed)).collect();
        let loads: Vec<&Load> = trim.chain(request.case.iter().flat_map(|case| &case.loads)).collect();
        let mut points = request.points.clone();
        points.extend(loads.iter().map(|load| load.point as usize));
        points.extend(data.sensors.iter().map(|sensor| sensor.point as usize));
        points.sort_unstable();
        points.dedup();
        if let Some(wrong) = points.iter().find(|point| **point >= data.points.len()) {
            return Err(format!(
                "a load acts on point {wrong}, of which the model has {}",
                data.points.len()
            ));
        }
        let point_names = points.iter().map(|&point| data.points[point].name.clone()).collect();
        let sensor_names = data.sensors.iter().map(|sensor| sensor.name.clone()).collect();
        let (source, mean_axes) = (request.model.data(), request.method == Method::MeanAxes);
        let start = match request.case {
            Some(case) => model.initial_state(case).map_err(|e| e.to_string())?,
            None => State::at_rest(model),
        };
        let m = model.n_modes();
        let of_point = |&index: &usize| Carrier::of_point(&data.points[index], index, m);
        let mut carriers: Vec<Carrier> = points.iter().map(of_point).collect();
        let mut lines = Vec::new();
        for (member, line) in data.lines.iter().enumerate() {
            let of_line = distributed.iter().filter(|load| load.member as usize == member);
            let before = lines.len();
            lines.extend(of_line.map(|load| (carriers.len(), *load)));
            if lines.len() > before {
                let earlier = data.lines.iter().take(member).map(|line| line.stations.len());
                let first = data.points.len() + earlier.sum::<usize>();
                carriers.extend(Carrier::of_stations(&line.stations, first, m));
            }
        }
        let sections = request.sections.clone();
        Ok(Self {
            model,
            source,
            scalar,
            mean_axes,
            points,
            point_names,
            sensor_names,
            carriers,
            sections,
            start,
            loads,
            lines,
        })
    }

    /// Time functions of all loads, the distributed ones last.
    pub(super) fn times(&self) -> impl Iterator<Item = &'a TimeFunction> {
        let lines = self.lines.iter().map(|(_, load)| &load.time);
        self.loads.iter().map(|load| &load.time).chain(lines)
    }

    /// Which of the model's points and stations each carrier is.
    pub(super) fn carriers(&self) -> impl Iterator<Item = usize> + '_ {
        self.carriers.iter().map(|carrier| carrier.index)
    }

    /// In the form the equations are written in.
    pub(super) fn data(&self) -> &ModelData {
        self.model.data()
    }

    pub(super) fn section_names(&self) -> Vec<String> {
        self.sections.iter().map(|&index| self.source.cuts[index].name.clone()).collect()
    }

    pub(super) fn n_modes(&self) -> usize {
        self.model.n_modes()
    }

    pub(super) fn n_points(&self) -> usize {
        self.points.len()
    }

    pub(super) fn n_sensors(&self) -> usize {
        self.sensor_names.len()
    }

    pub(super) fn point_names(&self) -> &[String] {
        &self.point_names
    }

    pub(super) fn sensor_names(&self) -> &[String] {
        &self.sensor_names
    }

    /// Place of a point of the model in the file.
    pub(super) fn place(&self, point: u32) -> usize {
        self.points.iter().position(|&kept| kept == point as usize).unwrap_or(0)
    }

    pub(super) fn to_text(&self) -> String {
        let mut text = self.macros();
        text += TYPES;
        self.modes(&mut text);
        self.tensors(&mut text);
        self.points_and_sensors(&mut text);
        self.rest(&mut text);
        text += &sections::tables(self);
        text
    }

    fn macros(&self) -> String {
        let data = self.model.data();
        let second = data.gravity.as_ref().is_some_and(|gravity| !gravity.second_moment.is_empty());
        let flag = |value: bool| i32::from(value);
        let m = self.n_modes();
        let mut text = String::new();
        let _ = writeln!(text, "#define ROM_SIZE {}", 2 * m + 13);
        let _ = writeln!(text, "#define ROM_N_PRODUCTS {}", (m + 6) * 6 + m * PAIRS as usize);
        let _ = writeln!(text, "#define ROM_CARRIERS {}", self.carriers.len());
        let _ = writeln!(text, "#define ROM_CARRIERS_OR_ONE {}", self.carriers.len().max(1));
        let _ = writeln!(text, "#define ROM_HAS_GRAVITY {}", flag(self.weighs()));
        let _ = writeln!(text, "#define ROM_HAS_SECOND_MOMENT {}", flag(second));
        let _ = writeln!(text, "#define ROM_HAS_COUPLED_DAMPING {}", flag(data.damping.is_some() && m > 0));
        let _ = writeln!(text, "#define ROM_HAS_TRIM {}", flag(data.trim.is_some()));
        let _ = writeln!(text, "#define ROM_MEAN_AXES {}", flag(self.mean_axes));
        let _ = writeln!(text, "#define ROM_HAS_JUMPS {}", flag(super::loads::has_jumps(self)));
        let (suffix, literal, epsilon) = if self.scalar.float {
            ("f", "#define R(x) x##f", "1.1920929e-7f")
        } else {
            ("", "#define R(x) x", "2.220446049250313e-16")
        };
        let _ = writeln!(text, "{literal}\n#define ROM_EPSILON {epsilon}");
        for name in [
            "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log",
            "log10", "fabs", "floor", "ceil", "pow", "fmin", "fmax", "atan2",
        ] {
            let _ = writeln!(text, "#define rom_{name} {name}{suffix}");
        }
        text
    }

    fn weighs(&self) -> bool {
        self.model.gravity() != [0.0; 3]
    }

    /// `static const rom_real NAME[dims] = { .. }`; one zero where there is nothing, as C has no empty arrays.
    fn array(&self, text: &mut String, name: &str, dims: &str, values: &[f64], width: usize) {
        let _ = write!(text, "\nstatic const rom_real {name}{dims} = {{");
        let zeros = vec![0.0; width];
        let rows = if values.is_empty() { &zeros } else { values };
        for (index, row) in rows.chunks(width).enumerate() {
            let separator = if index > 0 { "," } else { "" };
            let list = if width == 1 { self.scalar.literal(row[0]) } else { self.scalar.list(row) };
            let _ = write!(text, "{separator}\n    {list}");
        }
        text.push_str("\n};\n");
    }

    /// The same with braces around every row, however short.
    pub(super) fn matrix(&self, text: &mut String, name: &str, dims: &str, values: &[f64], width: usize) {
        let rows: Vec<String> = values.chunks(width).map(|row| self.scalar.list(row)).collect();
        let _ =
            writeln!(text, "\nstatic const rom_real {name}{dims} = {{\n    {}\n}};", rows.join(",\n    "));
    }

    fn modes(&self, text: &mut String) {
        let data = self.model.data();
        let modes = &data.modes;
        let each = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..self.n_modes()).map(f).collect() };
        let damping = |i: usize| 2.0 * modes.damping_ratio[i] * modes.omega[i] * modes.mass[i];
        let one = "[ROM_MODES_OR_ONE]";
        self.array(text, "INVERSE_MASS", one, &each(&|i| 1.0 / modes.mass[i]), 1);
        self.array(text, "DAMPING", one, &each(&damping), 1);
        self.array(text, "STIFFNESS", one, &each(&|i| modes.omega[i] * modes.omega[i] * modes.mass[i]), 1);
        if let Some(damping) = data.damping.as_ref().filter(|_| self.n_modes() > 0) {
            self.array(text, "COUPLED_DAMPING", "[ROM_MODES][ROM_MODES]", &damping.coupling, self.n_modes());
        }
        let phi_r = columns(&[(&modes.phi_r, 6)], self.n_modes());
        self.array(text, "PHI_R", "[ROM_MODES_OR_ONE][6]", &phi_r, 6);
        let inverse: Vec<f64> = self.model.rigid_mass_inverse().iter().flatten().copied().collect();
        self.array(text, "RIGID_MASS_INVERSE", "[6][6]", &inverse, 6);
    }

    /// Both tensors as one matrix by rows on the products of the state.
    fn tensors(&self, text: &mut String) {
        let data = self.model.data();
        let n = self.n_modes() as u32 + 6;
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n as usize];
        let entries = |t: &'a TensorData| t.i.iter().zip(&t.l).zip(&t.r).zip(&t.value);
        for (((&i, &l), &r), &value) in entries(&data.c) {
            rows[i as usize].push((l * 6 + r, value));
        }
        for (((&i, &l), &rs), &value) in entries(&data.k) {
            let (r, s) = (rs / 6, rs % 6);
            // Pairs (r, s) with r <= s, row by row.
            let pair = r * 6 - r * (r + 1) / 2 + s;
            rows[i as usize].push((n * 6 + l * PAIRS + pair, value));
        }
        let mut starts = vec![0];
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        for row in &mut rows {
            row.sort_unstable_by_key(|&(column, _)| column);
            columns.extend(row.iter().map(|entry| entry.0.to_string()));
            values.extend(row.iter().map(|entry| entry.1));
            starts.push(values.len());
        }
        let starts: Vec<String> = starts.iter().map(usize::to_string).collect();
        let _ = writeln!(text, "\nstatic const long ROW[ROM_MODES + 7] = {{ {} }};", wrapped(&starts));
        if columns.is_empty() {
            columns.push("0".to_owned());
        }
        let _ = writeln!(text, "\nstatic const int COLUMN[] = {{ {} }};", wrapped(&columns));
        let values = if values.is_empty() { vec![0.0] } else { values };
        let _ = writeln!(text, "\nstatic const rom_real VALUE[] = {};", self.scalar.list(&values));
    }

    fn point_row(&self, position: [f64; 3], quaternion: [f64; 4], offset: [f64; 3]) -> String {
        let list = |values: &[f64]| self.scalar.list(values);
        let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        let unit = quaternion.map(|x| x / norm);
        let rotation = rotation_matrix(unit);
        format!("{{ {}, {}, {}, {} }}", list(&position), list(&unit), list(&rotation), list(&offset))
    }

    fn points_and_sensors(&self, text: &mut String) {
        let m = self.n_modes();
        let none = || self.point_row([0.0; 3], [1.0, 0.0, 0.0, 0.0], [0.0; 3]);
        let row = |carrier: &Carrier| self.point_row(carrier.position, carrier.quaternion, carrier.offset);
        let mut rows: Vec<String> = self.carriers.iter().map(row).collect();
        if rows.is_empty() {
            rows.push(none());
        }
        let rows = rows.join(",\n    ");
        let _ = writeln!(text, "\nstatic const point_table POINT[ROM_CARRIERS_OR_ONE] = {{\n    {rows}\n}};");
        let shapes = |name: &str, n: &str, all: &mut dyn Iterator<Item = Vec<f64>>, text: &mut String| {
            let mut lists: Vec<String> = all.map(|values| self.rows_of_six(&values)).collect();
            if lists.is_empty() {
                lists.push(self.rows_of_six(&[]));
            }
            let lists = lists.join(",\n    ");
            let dims = format!("[{n}][ROM_MODES_OR_ONE][6]");
            let _ = writeln!(text, "\nstatic const rom_real {name}{dims} = {{\n    {lists}\n}};");
        };
        let mut own = self.carriers.iter().map(|carrier| carrier.phi.clone());
        shapes("POINT_PHI", "ROM_CARRIERS_OR_ONE", &mut own, text);
        // Displacements are relative to A, also where the equations are not written about it.
        if self.mean_axes && !self.points.is_empty() {
            let of = |&index: &usize| Carrier::of_point(&self.source.points[index], index, m).phi;
            shapes("POINT_SHAPE", "ROM_POINTS_OR_ONE", &mut self.points.iter().map(of), text);
        } else {
            text.push_str("#define POINT_SHAPE POINT_PHI\n");
        }
        let (origin, shape) = if self.mean_axes {
            let centre = self.source.rigid.centre_of_mass;
            (centre.map(|x| -x), columns(&[(&self.source.modes.phi_r, 6)], m))
        } else {
            ([0.0; 3], vec![0.0; 6 * m])
        };
        let row = self.point_row(origin, [1.0, 0.0, 0.0, 0.0], [0.0; 3]);
        let _ = writeln!(
            text,
            "\n/* Frame A as a node of the model's axes: at rest in them but in mean axes. */"
        );
        let _ = writeln!(text, "static const point_table FRAME_A = {row};");
        self.array(text, "FRAME_A_PHI", "[ROM_MODES_OR_ONE][6]", &shape, 6);
        self.sensors(text);
    }

    fn rows_of_six(&self, values: &[f64]) -> String {
        let zeros = [0.0; 6];
        let values = if values.is_empty() { &zeros[..] } else { values };
        let rows: Vec<String> = values.chunks(6).map(|row| self.scalar.list(row)).collect();
        format!("{{ {} }}", rows.join(",\n      "))
    }

    fn sensors(&self, text: &mut String) {
        let data = self.model.data();
        if data.sensors.is_empty() {
            return;
        }
        let row = |sensor: &rom_runtime::data::SensorData| {
            let axes: Vec<f64> = sensor.axes.iter().flatten().copied().collect();
            let gravity = if sensor.gravity { self.model.gravity() } else { [0.0; 3] };
            let (point, axes) = (self.place(sensor.point), self.scalar.list(&axes));
            format!("{{ {point}, {axes}, {} }}", self.scalar.list(&gravity))
        };
        let rows: Vec<String> = data.sensors.iter().map(row).collect();
        let rows = rows.join(",\n    ");
        let _ = writeln!(text, "\nstatic const sensor_table SENSOR[ROM_SENSORS] = {{\n    {rows}\n}};");
    }

    /// Weight, equilibrium, start.
    fn rest(&self, text: &mut String) {
        let (data, m) = (self.model.data(), self.n_modes());
        if self.weighs() {
            self.array(text, "GRAVITY", "[3]", &self.model.gravity(), 1);
            let _ = writeln!(text, "static const rom_real MASS = {};", self.scalar.literal(data.rigid.mass));
            let moment = data.rigid.centre_of_mass.map(|x| data.rigid.mass * x);
            self.array(text, "MASS_CENTRE", "[3]", &moment, 1);
            let first = columns(&[(&data.modes.first_moment, 3)], m);
            self.array(text, "FIRST_MOMENT", "[ROM_MODES_OR_ONE][3]", &first, 3);
            let momentum: Vec<f64> = self.model.modal_momentum().iter().flatten().copied().collect();
            self.array(text, "MOMENTUM", "[ROM_MODES_OR_ONE][3]", &momentum, 3);
            let second = data.gravity.as_ref().map_or(&[][..], |gravity| &gravity.second_moment);
            if !second.is_empty() {
                let values: Vec<String> = (0..m)
                    .map(|i| {
                        let row = (0..m).flat_map(|j| (0..3).map(move |k| second[(k * m + i) * m + j]));
                        let row: Vec<f64> = row.collect();
                        let vectors: Vec<String> = row.chunks(3).map(|v| self.scalar.list(v)).collect();
                        format!("{{ {} }}", vectors.join(", "))
                    })
                    .collect();
                let values = values.join(",\n    ");
                let _ = writeln!(
                    text,
                    "\nstatic const rom_real SECOND_MOMENT[ROM_MODES][ROM_MODES][3] = {{\n    {values}\n}};"
                );
            }
        }
        if let Some(trim) = &data.trim {
            self.array(text, "ELASTIC_FORCE", "[ROM_MODES_OR_ONE]", &trim.elastic_force, 1);
        }
        let modal = |values: &[f64]| self.scalar.list(if values.is_empty() { &[0.0] } else { values });
        let start = &self.start;
        let (zero, list) = (self.scalar.literal(0.0), |values: &[f64]| self.scalar.list(values));
        let parts = [
            modal(&start.q),
            modal(&start.q_dot),
            list(&start.beta_star),
            list(&start.attitude),
            list(&start.position),
        ];
        let _ = writeln!(
            text,
            "\n#define ROM_START {{ {zero}, {zero}, {} }}",
            parts.join(", ").replace('\n', " \\\n")
        );
    }
}

const TYPES: &str = "
/* Node position in the model's axes (m), node rotation as quaternion and matrix, and the point on it (node axes, m). */
typedef struct point_table {
    rom_real position[3], quaternion[4], rotation[9], offset[3];
} point_table;

#if ROM_SENSORS > 0
typedef struct sensor_table {
    int point;
    rom_real axes[9], gravity[3];
} sensor_table;
#endif
";

/// Columns of row-major arrays (rows x m) below one another, a column after the other.
fn columns(arrays: &[(&[f64], usize)], m: usize) -> Vec<f64> {
    let column = |j: usize| {
        arrays.iter().flat_map(move |(values, rows)| (0..*rows).map(move |row| values[row * m + j]))
    };
    (0..m).flat_map(column).collect()
}

/// Numbers on lines of a fair length.
fn wrapped(values: &[String]) -> String {
    let lines: Vec<String> = values.chunks(20).map(|line| line.join(", ")).collect();
    lines.join(",\n    ")
}

/// Row-major.
fn rotation_matrix(q: [f64; 4]) -> Vec<f64> {
    let unit = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
    let matrix = unit.to_rotation_matrix();
    (0..9).map(|at| matrix[(at / 3, at % 3)]).collect()
}
