//! From a [`Document`] to HTML.

use std::fmt::Write;

use serde_json::{Value, json};

use super::encode::Arrays;
use super::{Block, Curves, Document, Plot, Table, decimate, scene};
use crate::scene::Scene;
use crate::text::looks_numeric;

/// Points per plot above which curves are thinned out.
const POINT_LIMIT: usize = 4_000;

/// Characters from which the text of a table cell is broken into lines.
const LONG_CELL: usize = 45;

/// Only what is inside the page may run or be shown: nothing is fetched, whatever a name in it contains.
const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

pub(super) fn render(document: &Document) -> String {
    let mut page = Page::default();
    let body = page.body(document);
    let views = if page.scenes.is_empty() { String::new() } else { scene::scripts() };
    let data = page.data();
    let title = escape(&document.title);
    format!(
        r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>{plot_css}
{css}</style>
</head>
<body>
{body}
<script type="application/json" id="data">{data}</script>
<script>{plot_js}</script>
<script>{js}</script>
{views}</body>
</html>
"#,
        plot_css = include_str!("assets/uPlot.min.css"),
        css = include_str!("assets/report.css"),
        plot_js = include_str!("assets/uPlot.iife.min.js"),
        js = include_str!("assets/report.js"),
    )
}

/// What has been put on the page so far.
#[derive(Default)]
struct Page {
    arrays: Arrays,
    plots: Vec<Value>,
    scenes: Vec<Value>,
}

impl Page {
    fn body(&mut self, document: &Document) -> String {
        let mut html = format!(
            "<header><h1>{}</h1><p class=\"subtitle\">{}</p>",
            escape(&document.title),
            escape(&document.subtitle)
        );
        if !document.highlights.is_empty() {
            html.push_str("<dl class=\"highlights\">");
            for h in &document.highlights {
                let (label, value, note) = (escape(&h.label), escape(&h.value), escape(&h.note));
                let _ = write!(html, "<div><dt>{label}</dt><dd>{value}<small>{note}</small></dd></div>");
            }
            html.push_str("</dl>");
        }
        html.push_str("</header>\n<noscript><p class=\"warning\">The plots need JavaScript, which this browser does not \
            run for this page. The tables do not.</p></noscript>\n<main>\n");
        for section in &document.sections {
            let _ = writeln!(html, "<section><h2>{}</h2>", escape(&section.title));
            self.blocks(&mut html, &section.blocks);
            html.push_str("</section>\n");
        }
        let _ = write!(html, "</main>\n<footer>{}</footer>", escape(&document.footer));
        html
    }

    fn blocks(&mut self, html: &mut String, blocks: &[Block]) {
        let mut in_grid = false;
        for block in blocks {
            let is_plot = matches!(block, Block::Plot(_) | Block::Picture { .. });
            if is_plot != in_grid {
                html.push_str(if is_plot { "<div class=\"plots\">" } else { "</div>" });
                in_grid = is_plot;
            }
            match block {
                Block::Text(text) => _ = writeln!(html, "<p>{}</p>", escape(text)),
                Block::Note(text) => _ = writeln!(html, "<p class=\"note\">{}</p>", escape(text)),
                Block::Warning(text) => _ = writeln!(html, "<p class=\"warning\">{}</p>", escape(text)),
                Block::Verbatim(text) => _ = writeln!(html, "<pre>{}</pre>", escape(text)),
                Block::Facts(facts) => push_facts(html, facts),
                Block::Table(table) => push_table(html, table),
                Block::Plot(plot) => self.push_plot(html, plot),
                Block::Picture { svg, caption } => {
                    let caption = escape(caption);
                    let _ = writeln!(
                        html,
                        "<figure class=\"picture\"><figcaption>{caption}</figcaption>{svg}</figure>"
                    );
                }
                Block::Scene(scene) => self.push_scene(html, scene),
            }
        }
        if in_grid {
            html.push_str("</div>");
        }
    }

    fn push_plot(&mut self, html: &mut String, plot: &Plot) {
        let (kind, arrays, names, kept, total) = match &plot.curves {
            Curves::Over { x, series } => self.add_functions(x, series),
            Curves::Paths(paths) => self.add_paths(paths),
        };
        let index = self.plots.len();
        let look = &plot.look;
        self.plots.push(json!({
            "kind": kind, "x": plot.x_label, "y": plot.y_label, "names": names, "arrays": arrays,
            "logX": look.log_x, "logY": look.log_y, "markers": look.markers || look.scattered, "scattered": look.scattered, "stages": look.stages,
        }));
        let mut note = escape(&plot.note);
        if kept < total {
            let gap = if note.is_empty() { "" } else { " " };
            let _ = write!(note, "{gap}{kept} of {total} points drawn; every peak is among them.");
        }
        let title = escape(&plot.title);
        let _ = write!(
            html,
            "<figure class=\"{kind}\"><figcaption>{title}</figcaption><div class=\"plot\" data-plot=\"{index}\" \
             role=\"img\" aria-label=\"{title}\"></div><p class=\"note\">{note}</p></figure>"
        );
    }

    fn push_scene(&mut self, html: &mut String, scene: &Scene) {
        let (index, title) = (self.scenes.len(), escape(&scene.title));
        self.scenes.push(scene::encode(scene, &mut self.arrays));
        let _ = writeln!(
            html,
            "<figure class=\"scene\"><figcaption>{title}</figcaption><div class=\"view\" data-scene=\"{index}\"></div></figure>"
        );
    }

    fn add_functions(&mut self, x: &[f64], series: &[(String, Vec<f64>)]) -> Prepared {
        let values: Vec<&[f64]> = series.iter().map(|(_, y)| y.as_slice()).collect();
        let kept = decimate(x.len(), &values, POINT_LIMIT);
        let mut arrays = vec![self.add(x, kept.as_deref())];
        arrays.extend(values.iter().map(|y| self.add(y, kept.as_deref())));
        let names = series.iter().map(|(name, _)| name.clone()).collect();
        ("over", json!(arrays), names, kept.map_or(x.len(), |k| k.len()), x.len())
    }

    fn add_paths(&mut self, paths: &[(String, Vec<f64>, Vec<f64>)]) -> Prepared {
        let (mut arrays, mut names, mut drawn, mut total) = (Vec::new(), Vec::new(), 0, 0);
        for (name, x, y) in paths {
            let kept = decimate(x.len(), &[x, y], POINT_LIMIT);
            arrays.push([self.add(x, kept.as_deref()), self.add(y, kept.as_deref())]);
            names.push(name.clone());
            drawn += kept.map_or(x.len(), |k| k.len());
            total += x.len();
        }
        ("paths", json!(arrays), names, drawn, total)
    }

    fn add(&mut self, values: &[f64], kept: Option<&[usize]>) -> usize {
        match kept {
            Some(kept) => self.arrays.add(kept.iter().map(|&i| values[i])),
            None => self.arrays.add(values.iter().copied()),
        }
    }

    /// The data of all plots as JSON that may stand inside a script element.
    fn data(self) -> String {
        let data = json!({ "arrays": self.arrays.into_texts(), "plots": self.plots, "scenes": self.scenes });
        // "</script>" in a name would end the element; JSON may write "<" as an escape anywhere it can occur.
        data.to_string().replace('<', "\\u003c")
    }
}

/// Kind, array indices, names of the curves, points drawn, points given.
type Prepared = (&'static str, Value, Vec<String>, usize, usize);

fn push_facts(html: &mut String, facts: &[(String, String)]) {
    html.push_str("<dl class=\"facts\">");
    for (name, value) in facts {
        let _ = write!(html, "<dt>{}</dt><dd>{}</dd>", escape(name), escape(value));
    }
    html.push_str("</dl>\n");
}

fn push_table(html: &mut String, table: &Table) {
    html.push_str("<div class=\"table\"><table>");
    if !table.caption.is_empty() {
        let _ = write!(html, "<caption>{}</caption>", escape(&table.caption));
    }
    let numeric: Vec<bool> = (0..table.columns.len()).map(|j| is_numeric(table, j)).collect();
    let class = |j: usize| if numeric.get(j).copied().unwrap_or(false) { " class=\"number\"" } else { "" };
    html.push_str("<thead><tr>");
    for (j, column) in table.columns.iter().enumerate() {
        let _ = write!(html, "<th scope=\"col\"{}>{}</th>", class(j), escape(column));
    }
    html.push_str("</tr></thead><tbody>");
    for row in &table.rows {
        html.push_str("<tr>");
        for (j, cell) in row.iter().enumerate() {
            let class = if cell.chars().count() > LONG_CELL { " class=\"long\"" } else { class(j) };
            let _ = write!(html, "<td{class}>{}</td>", escape(cell));
        }
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table></div>\n");
}

/// A column is numeric when every cell starts like a number or is empty.
fn is_numeric(table: &Table, column: usize) -> bool {
    table.rows.iter().filter_map(|row| row.get(column)).all(|cell| looks_numeric(cell))
}

/// Text as it may stand in an element or in a quoted attribute.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}
