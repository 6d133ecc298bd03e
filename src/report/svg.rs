//! The plots of a page as SVG files, for papers.

use std::io;
use std::path::Path;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

use super::{Block, Curves, Document, Plot, decimate};
use crate::atomic;
use crate::text::significant;

/// Units a point on paper: coordinates are whole numbers of units, and curves should not show it.
const FINE: u32 = 4;

/// Size in units.
const SIZE: (u32, u32) = (640 * FINE, 400 * FINE);

/// Points per plot above which curves are thinned out: finer than any printer.
const POINT_LIMIT: usize = 8_000;

/// The colours of the page on white.
const COLOURS: [RGBColor; 10] = [
    RGBColor(0x17, 0x63, 0xb5),
    RGBColor(0xd4, 0x57, 0x0c),
    RGBColor(0x1a, 0x8a, 0x4c),
    RGBColor(0x8a, 0x45, 0xc4),
    RGBColor(0xb8, 0x32, 0x6f),
    RGBColor(0x7d, 0x6b, 0x00),
    RGBColor(0x0d, 0x83, 0x90),
    RGBColor(0x8b, 0x4a, 0x2b),
    RGBColor(0x55, 0x60, 0x6e),
    RGBColor(0x3d, 0x3f, 0xb8),
];

/// A curve by its name and the points of its pieces: gaps cut it.
type Curve = (String, Vec<Vec<(f64, f64)>>);

impl Document {
    /// Writes every plot of the page as `NUMBER-TITLE.svg` into `folder`; returns how many there are.
    ///
    /// # Errors
    /// Those of the file system, naming the file.
    pub fn write_svg(&self, folder: &Path) -> io::Result<usize> {
        atomic::make_folder(folder)?;
        let blocks = self.sections.iter().flat_map(|section| &section.blocks);
        let plots = blocks.filter_map(|block| if let Block::Plot(plot) = block { Some(plot) } else { None });
        let mut count = 0;
        for plot in plots {
            count += 1;
            let name = format!("{count:02}-{}", plain(&plot.title));
            let text = plot.to_svg()?;
            atomic::write(&folder.join(format!("{name}.svg")), |sink| sink.write_all(text.as_bytes()))?;
        }
        Ok(count)
    }
}

impl Plot {
    /// The plot as an SVG image.
    ///
    /// # Errors
    /// When its numbers cannot be drawn.
    pub fn to_svg(&self) -> io::Result<String> {
        svg(self).map_err(|e| io::Error::other(format!("plot {}: {e}", self.title)))
    }
}

/// A title as part of a name that no system and no typesetter stumbles over.
fn plain(title: &str) -> String {
    let words = title.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-").to_lowercase()
}

/// One plot.
fn svg(plot: &Plot) -> Result<String, Box<dyn std::error::Error>> {
    let curves = curves(plot);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let (mut x, mut y) =
            (range(&curves, |p| p.0, plot.look.log_x), range(&curves, |p| p.1, plot.look.log_y));
        if matches!(plot.curves, Curves::Paths(_)) {
            // About the plane that is left beside the labels.
            let (width, height) = (f64::from(SIZE.0 - 90 * FINE), f64::from(SIZE.1 - 80 * FINE));
            let unit = ((x.1 - x.0) / width).max((y.1 - y.0) / height);
            (x, y) = (widened(x, unit * width), widened(y, unit * height));
        }
        match (plot.look.log_x, plot.look.log_y) {
            (false, false) => draw(&area, plot, &curves, x.0..x.1, y.0..y.1)?,
            (false, true) => draw(&area, plot, &curves, x.0..x.1, (y.0..y.1).log_scale())?,
            (true, false) => draw(&area, plot, &curves, (x.0..x.1).log_scale(), y.0..y.1)?,
            (true, true) => draw(&area, plot, &curves, (x.0..x.1).log_scale(), (y.0..y.1).log_scale())?,
        }
        area.present()?;
    }
    Ok(text)
}

fn draw<X, Y>(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    plot: &Plot,
    curves: &[Curve],
    x: X,
    y: Y,
) -> Result<(), Box<dyn std::error::Error>>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
    Y::CoordDescType: ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(&plot.title, ("sans-serif", 16 * FINE))
        .margin(10 * FINE)
        .x_label_area_size(36 * FINE)
        .y_label_area_size(64 * FINE)
        .build_cartesian_2d(x, y)?;
    let grey = RGBColor(0xe6, 0xe9, 0xee);
    // Ticks are sums of steps: what is round-off of zero reads as zero.
    let number =
        |largest: f64| move |v: &f64| significant(if v.abs() < 1e-9 * largest { 0.0 } else { *v }, 4);
    let largest = |of: fn(&(f64, f64)) -> f64| {
        curves.iter().flat_map(|(_, pieces)| pieces.iter().flatten()).fold(0.0_f64, |m, p| m.max(of(p).abs()))
    };
    let (x_number, y_number) = (number(largest(|p| p.0)), number(largest(|p| p.1)));
    chart
        .configure_mesh()
        .x_desc(&plot.x_label)
        .y_desc(&plot.y_label)
        .light_line_style(WHITE)
        .x_label_formatter(&x_number)
        .y_label_formatter(&y_number)
        .label_style(("sans-serif", 12 * FINE))
        .axis_desc_style(("sans-serif", 13 * FINE))
        .set_all_tick_mark_size(5 * FINE)
        .bold_line_style(grey.stroke_width(FINE))
        .axis_style(BLACK.stroke_width(FINE))
        .draw()?;
    for (i, (name, pieces)) in curves.iter().enumerate() {
        let colour = if plot.look.stages {
            // From light to dark.
            let share = 190 - (150 * i / (curves.len().max(2) - 1)) as u8;
            RGBColor(share, share, share)
        } else {
            COLOURS[i % COLOURS.len()]
        };
        let style = colour.stroke_width(FINE * if plot.look.stages { 1 } else { 2 });
        for (k, piece) in pieces.iter().enumerate() {
            // Marks alone have a line without length, which the legend hangs on.
            let line = if plot.look.scattered { &piece[..1] } else { &piece[..] };
            let drawn = chart.draw_series(LineSeries::new(line.iter().copied(), style))?;
            if k == 0 && !plot.look.stages {
                let named = drawn.label(name);
                let (half, whole) = (8 * FINE as i32, 16 * FINE as i32);
                if plot.look.scattered {
                    named.legend(move |(x, y)| Circle::new((x + half, y), 3 * FINE, style.filled()));
                } else {
                    named.legend(move |(x, y)| PathElement::new(vec![(x, y), (x + whole, y)], style));
                }
            }
            if plot.look.markers || plot.look.scattered {
                chart.draw_series(piece.iter().map(|&p| Circle::new(p, 3 * FINE, colour.filled())))?;
            }
        }
        // A ring marks the start of a path.
        if let (Curves::Paths(_), false, Some(&start)) =
            (&plot.curves, plot.look.stages, pieces.iter().flatten().next())
        {
            chart.draw_series([Circle::new(start, 4 * FINE, style)])?;
        }
    }
    if curves.len() > 1 && !plot.look.stages {
        chart
            .configure_series_labels()
            .position(emptiest(plot, curves))
            .legend_area_size(30 * FINE)
            .margin(6 * FINE)
            .background_style(WHITE.mix(0.85))
            .border_style(grey)
            .label_font(("sans-serif", 12 * FINE))
            .draw()?;
    }
    Ok(())
}

/// The corner where the legend hides least.
fn emptiest(plot: &Plot, curves: &[Curve]) -> SeriesLabelPosition {
    let (x, y) = (range(curves, |p| p.0, plot.look.log_x), range(curves, |p| p.1, plot.look.log_y));
    let share = |v: f64, (a, b): (f64, f64), log: bool| {
        if log { (v.ln() - a.ln()) / (b.ln() - a.ln()) } else { (v - a) / (b - a) }
    };
    let points: Vec<(f64, f64)> = curves
        .iter()
        .flat_map(|(_, pieces)| pieces.iter().flatten())
        .map(|p| (share(p.0, x, plot.look.log_x), share(p.1, y, plot.look.log_y)))
        .collect();
    let hidden = |right: bool, upper: bool| {
        let inside = |v: f64, far: bool, size: f64| if far { v > 1.0 - size } else { v < size };
        points.iter().filter(|p| inside(p.0, right, 0.25) && inside(p.1, upper, 0.4)).count()
    };
    let corners = [
        (SeriesLabelPosition::UpperRight, hidden(true, true)),
        (SeriesLabelPosition::UpperLeft, hidden(false, true)),
        (SeriesLabelPosition::LowerRight, hidden(true, false)),
        (SeriesLabelPosition::LowerLeft, hidden(false, false)),
    ];
    // The first of those that hide as little as any.
    corners
        .into_iter()
        .min_by_key(|corner| corner.1)
        .map_or(SeriesLabelPosition::UpperRight, |corner| corner.0)
}

fn curves(plot: &Plot) -> Vec<Curve> {
    let positive = |(x, y): &(f64, f64)| (!plot.look.log_x || *x > 0.0) && (!plot.look.log_y || *y > 0.0);
    let pieces = |x: &[f64], y: &[f64]| {
        let kept = decimate(x.len(), &[x, y], POINT_LIMIT).unwrap_or_else(|| (0..x.len()).collect());
        let points: Vec<(f64, f64)> = kept.into_iter().map(|i| (x[i], y[i])).collect();
        let usable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite() && positive(p);
        points.split(|p| !usable(p)).filter(|piece| !piece.is_empty()).map(<[_]>::to_vec).collect()
    };
    match &plot.curves {
        Curves::Over { x, series } => series.iter().map(|(name, y)| (name.clone(), pieces(x, y))).collect(),
        Curves::Paths(paths) => paths.iter().map(|(name, x, y)| (name.clone(), pieces(x, y))).collect(),
    }
}

/// Range of a coordinate with some air around; never empty.
fn range(curves: &[Curve], of: impl Fn(&(f64, f64)) -> f64, log: bool) -> (f64, f64) {
    let values = curves.iter().flat_map(|(_, pieces)| pieces.iter().flatten().map(&of));
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if least > most {
        return if log { (0.1, 10.0) } else { (-1.0, 1.0) };
    }
    if log {
        return (least / 1.3, most * 1.3);
    }
    let air = 0.04 * (most - least);
    if air > 0.0 { (least - air, most + air) } else { widened((least, most), 2.0 * least.abs().max(0.5)) }
}

/// A range of this length about the same middle.
fn widened((a, b): (f64, f64), length: f64) -> (f64, f64) {
    let middle = 0.5 * (a + b);
    (middle - 0.5 * length, middle + 0.5 * length)
}
