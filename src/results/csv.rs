//! Comma-separated values.

use std::io::{self, Write};

use super::Results;

pub(super) fn write(results: &Results, sink: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let header: Vec<String> = results
        .channels()
        .iter()
        .flat_map(|channel| channel.column_names().into_iter().map(|name| quoted(&name)))
        .collect();
    writeln!(sink, "{}", header.join(","))?;
    for i in 0..results.rows() {
        let mut separator = "";
        for value in results.channels().iter().flat_map(|channel| channel.row(i)) {
            // Debug, unlike Display, has a short form for very large and very small numbers; both read back exactly.
            write!(sink, "{separator}{value:?}")?;
            separator = ",";
        }
        writeln!(sink)?;
    }
    Ok(())
}

/// A point may be called almost anything; RFC 4180 quoting where its name needs it.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
