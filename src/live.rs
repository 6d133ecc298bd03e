//! A run in work, as a few lines on the terminal: a plot over time and the figures of now.

use std::time::{Duration, Instant};

use indicatif::ProgressBar;

use crate::march::Marching;
use crate::text::significant;

/// Time between two pictures: smooth to the eye, nothing to the run.
const REFRESH: Duration = Duration::from_millis(100);

/// Size of the plot in characters; each holds two by four dots.
const COLUMNS: usize = 64;
const ROWS: usize = 8;

/// What is shown of a run.
pub struct Live {
    bar: ProgressBar,
    /// Points watched: index in the run, and name.
    points: Vec<(usize, String)>,
    dt: f64,
    steps: u64,
    /// Of every column of dots the least and the most of the largest displacement, where there is any.
    history: Vec<Option<(f64, f64)>>,
    drawn: Instant,
    start: Instant,
}

impl Live {
    /// Follows a run of `steps` steps of `dt` (s) on `bar`, watching these points.
    pub fn new(bar: ProgressBar, points: Vec<(usize, String)>, steps: u64, dt: f64) -> Self {
        let now = Instant::now();
        Self { bar, points, dt, steps, history: vec![None; 2 * COLUMNS], drawn: now, start: now }
    }

    /// Takes in the state after `step` steps, and shows it when it is time.
    pub fn see(&mut self, step: u64, run: &dyn Marching) {
        let largest = self.displacements(run).map(|(_, length)| length).fold(0.0, f64::max);
        let last = self.history.len() - 1;
        let column = ((step as f64 / self.steps.max(1) as f64 * last as f64) as usize).min(last);
        let (least, most) = self.history[column].unwrap_or((largest, largest));
        self.history[column] = Some((least.min(largest), most.max(largest)));
        if self.drawn.elapsed() >= REFRESH {
            self.drawn = Instant::now();
            self.bar.set_message(self.text(step, run));
        }
    }

    fn displacements<'a>(&'a self, run: &'a dyn Marching) -> impl Iterator<Item = (&'a str, f64)> + 'a {
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.points
            .iter()
            .filter_map(move |(index, name)| Some((name.as_str(), length(run.point(*index)?.dr_a))))
    }

    /// The picture after `step` steps.
    pub fn text(&self, step: u64, run: &dyn Marching) -> String {
        let (rigid, ledger) = (run.rigid(), run.ledger());
        let t = step as f64 * self.dt;
        let seconds = self.start.elapsed().as_secs_f64().max(1e-9);
        let mut text = format!(
            "t = {} of {} s, {} times real time\n",
            significant(t, 5),
            significant(self.steps as f64 * self.dt, 5),
            significant(t / seconds, 3)
        );
        let figures = |v: [f64; 3]| v.map(|x| format!("{x:>10.3}")).concat();
        text += &format!("v_G {} m/s    w_G {} rad/s\n", figures(rigid.v_g), figures(rigid.w_g));
        text += &format!(
            "E_kin {} J, E_el {} J\n",
            significant(ledger.kinetic_energy, 4),
            significant(ledger.elastic_energy, 4)
        );
        let mut moving: Vec<(&str, f64)> =
            self.displacements(run).filter(|(_, length)| *length > 0.0).collect();
        moving.sort_by(|a, b| b.1.total_cmp(&a.1));
        let told: Vec<String> = moving
            .iter()
            .take(4)
            .map(|(name, length)| format!("{name} {} m", significant(*length, 3)))
            .collect();
        if !told.is_empty() {
            text += &format!("displaced by: {}\n", told.join(", "));
        }
        text + &plot(&self.history, ROWS)
    }
}

/// A filled band over the columns, in characters of two by four dots, with the scale at its left.
fn plot(history: &[Option<(f64, f64)>], rows: usize) -> String {
    let top = history.iter().flatten().fold(0.0_f64, |top, (_, most)| top.max(*most));
    let top = if top > 0.0 { top } else { 1.0 };
    let dots = 4 * rows;
    // Bits of the dots of a character, from its top: left column, right column (Unicode, Braille patterns).
    const BITS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
    let height = |value: f64| ((value / top * (dots - 1) as f64).round() as usize).min(dots - 1);
    let mut text = String::new();
    for row in 0..rows {
        let label = match row {
            0 => format!("{:>9} m ", significant(top, 3)),
            _ if row + 1 == rows => format!("{:>9} m ", 0),
            _ => " ".repeat(12),
        };
        text += &label;
        for pair in history.chunks(2) {
            let mut bits = 0;
            for (column, value) in pair.iter().enumerate() {
                let Some((least, most)) = value else { continue };
                for dot in 0..4 {
                    let level = dots - 1 - (4 * row + dot);
                    if (height(*least)..=height(*most)).contains(&level) {
                        bits |= BITS[column][dot];
                    }
                }
            }
            text.push(char::from_u32(0x2800 + bits).unwrap_or(' '));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_rises_from_the_lower_left_to_the_upper_right() {
        let history: Vec<Option<(f64, f64)>> = (0..8).map(|i| Some((f64::from(i), f64::from(i)))).collect();
        let text = plot(&history, 2);
        let rows: Vec<&str> = text.lines().map(|line| &line[12..]).collect();
        assert_eq!(rows, ["⠀⠀⡠⠊", "⡠⠊⠀⠀"]);
        assert!(text.starts_with("        7 m "), "{text}");
    }

    #[test]
    fn what_has_not_been_reached_is_empty() {
        let text = plot(&[Some((1.0, 1.0)), None, None, None], 1);
        assert_eq!(text.lines().next().unwrap().chars().skip(12).collect::<String>(), "⠁⠀");
    }
}
