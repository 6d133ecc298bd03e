//! Loads and time functions in words.

use rom_runtime::data::{ModelData, PointData};
use rom_runtime::loads::{DistributedFrame, DistributedLoad, Load, LoadCase, LoadFrame};
use rom_runtime::time::TimeFunction;

use crate::text::{significant, vector};

/// A function of time in words, for example `ramp of 100 per s from 0 s to 10 s`.
pub fn time_function(function: &TimeFunction) -> String {
    let n = |value: f64| significant(value, 6);
    let until = |end: f64| if end >= f64::MAX { "on".to_owned() } else { format!("to {} s", n(end)) };
    match function {
        TimeFunction::Constant { value } => format!("constant {}", n(*value)),
        TimeFunction::Step { value, start, end } => {
            format!("{} from {} s {}", n(*value), n(*start), until(*end))
        }
        TimeFunction::Ramp { rate, start, end } => {
            format!("ramp of {} per s from {} s {}", n(*rate), n(*start), until(*end))
        }
        TimeFunction::Triangle { peak, start, at, end } => {
            format!("triangle of {} at {} s, from {} s {}", n(*peak), n(*at), n(*start), until(*end))
        }
        TimeFunction::Sine { amplitude, omega, phase, start, end } => format!(
            "sine of {} at {} rad/s, phase {} rad, from {} s {}",
            n(*amplitude),
            n(*omega),
            n(*phase),
            n(*start),
            until(*end)
        ),
        TimeFunction::OneMinusCosine { amplitude, start, duration } => {
            format!("1-cosine of {} from {} s for {} s", n(*amplitude), n(*start), n(*duration))
        }
        TimeFunction::Table { t, value } => {
            let range = |values: &[f64]| {
                (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0))
            };
            let ((start, end), (first, last)) = (range(t), range(value));
            format!(
                "table of {} values from {} at {} s to {} at {} s",
                t.len(),
                n(first),
                n(start),
                n(last),
                n(end)
            )
        }
        TimeFunction::Expression { program } => program.source.clone(),
    }
}

/// Point, frame, force, moment and function of time of a load, in words.
pub fn load(load: &Load, points: &[PointData]) -> [String; 5] {
    let point = points.get(load.point as usize);
    let frames = point.into_iter().flat_map(|p| &p.sections).map(|(member, frame)| (member.as_str(), *frame));
    load_at(load, point.map(|p| p.name.as_str()), frames)
}

/// The same for a point that is known by its name and the members that meet there, with their section frames.
pub fn load_at<'a>(
    load: &Load,
    point: Option<&str>,
    mut sections: impl Iterator<Item = (&'a str, [[f64; 3]; 3])>,
) -> [String; 5] {
    let frame = match &load.frame {
        LoadFrame::Dead => "dead (G)".to_owned(),
        LoadFrame::Body => "body (A)".to_owned(),
        LoadFrame::Follower { section } => {
            let member = sections.find(|(_, frame)| frame == section);
            member.map_or("follower".to_owned(), |(name, _)| format!("follower, section of {name}"))
        }
    };
    let six = |v: &[f64; 3]| if v.iter().all(|&c| c == 0.0) { "–".to_owned() } else { vector(v, 6) };
    let name = point.map_or_else(|| format!("point {}", load.point), str::to_owned);
    [name, frame, six(&load.force), six(&load.moment), time_function(&load.time)]
}

/// The same of a distributed load on a member, with the sums of its forces and moments.
pub fn distributed(load: &DistributedLoad, member: Option<&str>) -> [String; 5] {
    let frame = match load.frame {
        DistributedFrame::Dead => "dead (G)",
        DistributedFrame::Body => "body (A)",
        DistributedFrame::Follower => "follower, section by section",
    };
    let total = |list: &[f64]| {
        let sum = list.as_chunks::<3>().0.iter().fold([0.0; 3], |s, v| [0, 1, 2].map(|k| s[k] + v[k]));
        if list.is_empty() { "–".to_owned() } else { format!("{} in all", vector(&sum, 6)) }
    };
    let place = member.map_or_else(|| format!("member {}", load.member), |name| format!("along {name}"));
    [place, frame.to_owned(), total(&load.force), total(&load.moment), time_function(&load.time)]
}

/// Names of the points that carry a load in some case of the model, in the model's order.
pub fn loaded_points(data: &ModelData) -> Vec<&PointData> {
    let carries =
        |i: usize| data.load_cases.iter().flat_map(|case| &case.loads).any(|l| l.point as usize == i);
    data.points.iter().enumerate().filter(|(i, _)| carries(*i)).map(|(_, p)| p).collect()
}

/// Heading and one row per load case.
pub fn load_case_rows(cases: &[LoadCase]) -> Vec<Vec<String>> {
    let heading = ["load case", "t_end (s)", "dt (s)", "damping", "loads", "description"];
    let mut rows = vec![heading.map(String::from).to_vec()];
    rows.extend(cases.iter().map(|case| {
        vec![
            case.name.clone(),
            significant(case.t_end, 6),
            significant(case.dt, 6),
            significant(case.numerical_damping, 6),
            (case.loads.len() + case.distributed.len()).to_string(),
            case.description.clone(),
        ]
    }));
    rows
}
