//! Reports: self-contained HTML pages that open offline in any browser.
//!
//! A [`Document`] is sections of text, facts, tables and plots; [`Document::to_html`] renders it, so that every
//! command that reports something only says what is in it. Plots are drawn by uPlot, views in space by three.js;
//! both are inside the page.

mod decimate;
mod encode;
mod html;
mod scene;
mod svg;

pub use decimate::decimate;

use std::io;
use std::path::Path;

use crate::atomic;
use crate::scene::Scene;

/// A page.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// Heading of the page.
    pub title: String,
    /// One line below it.
    pub subtitle: String,
    /// The few figures to see first.
    pub highlights: Vec<Highlight>,
    /// Body.
    pub sections: Vec<Section>,
    /// Last line: which tool wrote the page.
    pub footer: String,
}

/// A figure worth its own box at the top.
#[derive(Clone, Debug)]
pub struct Highlight {
    /// What it is.
    pub label: String,
    /// The figure with its unit.
    pub value: String,
    /// A short remark below it, or empty.
    pub note: String,
}

/// A titled part of a page.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// Contents; neighbouring plots share a row where the window is wide enough.
    pub blocks: Vec<Block>,
}

/// One piece of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A remark in small type.
    Note(String),
    /// A paragraph that must not be overlooked: a failure, a disagreement.
    Warning(String),
    /// Names and values.
    Facts(Vec<(String, String)>),
    /// A table.
    Table(Table),
    /// Text in which line breaks count: an input file, a command.
    Verbatim(String),
    /// Curves.
    Plot(Plot),
    /// A drawing.
    Picture {
        /// An SVG element, made by this program: it goes into the page as it is.
        svg: String,
        /// What it shows.
        caption: String,
    },
    /// A structure that moves in space.
    Scene(Box<Scene>),
}

/// Rows under column headings.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Column headings.
    pub columns: Vec<String>,
    /// Cells; texts that read as numbers are set flush right.
    pub rows: Vec<Vec<String>>,
}

/// Curves over two axes.
#[derive(Clone, Debug, Default)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    /// The curves.
    pub curves: Curves,
    /// A remark below the plot, or empty.
    pub note: String,
    /// How it is drawn.
    pub look: Look,
}

/// How a plot is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// Logarithmic horizontal axis, for curves over a variable; all values must be positive.
    pub log_x: bool,
    /// Logarithmic vertical axis, for curves over a variable; values that are not positive are left out.
    pub log_y: bool,
    /// A mark at every point: for curves of a few points.
    pub markers: bool,
    /// Marks alone, without lines between them: for curves over a variable that are clouds of points.
    pub scattered: bool,
    /// The curves are stages of one thing, from first (light) to last (dark): no colours, no legend, no ring at the start of
    /// a path.
    pub stages: bool,
}

/// How the curves of a plot are given.
#[derive(Clone, Debug)]
pub enum Curves {
    /// Functions of one increasing variable, common to all: (name, values - (n)).
    Over {
        /// The common variable - (n).
        x: Vec<f64>,
        /// Name and values of each curve - (n).
        series: Vec<(String, Vec<f64>)>,
    },
    /// Paths in a plane, drawn with the same scale on both axes: (name, x - (n), y - (n)).
    Paths(Vec<(String, Vec<f64>, Vec<f64>)>),
}

impl Default for Curves {
    fn default() -> Self {
        Self::Paths(Vec::new())
    }
}

impl Document {
    /// The page as one HTML text without references to other files.
    pub fn to_html(&self) -> String {
        html::render(self)
    }

    /// Writes the page.
    ///
    /// # Errors
    /// Those of the file system, naming the file.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let html = self.to_html();
        atomic::write(path, |sink| sink.write_all(html.as_bytes()))
    }
}

#[cfg(test)]
mod tests;
