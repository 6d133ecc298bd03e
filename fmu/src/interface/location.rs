//! Where the resources of an FMU are.

use std::path::PathBuf;

/// The folder behind the location that FMI 2.0 gives: a URI.
///
/// # Errors
/// Other URIs than those of local files.
pub(super) fn from_uri(uri: &str) -> Result<PathBuf, String> {
    let refuse = |what| Err(format!("the location of the resources is \"{uri}\", {what}"));
    let lower = uri.get(..5).map(str::to_ascii_lowercase);
    let path = match lower.as_deref() {
        Some("file:") => &uri[5..],
        // Some hosts give a plain path.
        _ if !uri.contains("://") => return Ok(PathBuf::from(uri)),
        _ => return refuse("expected one that starts with file:"),
    };
    let path = match path.strip_prefix("//") {
        Some(rest) => match rest.find('/') {
            Some(slash) if matches!(&rest[..slash], "" | "localhost") => &rest[slash..],
            _ => return refuse("expected a file of this machine"),
        },
        None => path,
    };
    let Some(path) = decoded(path) else { return refuse("which holds a broken escape") };
    // file:///C:/folder
    let drive = path.as_bytes();
    let from = usize::from(cfg!(windows) && drive.len() > 2 && drive[0] == b'/' && drive[2] == b':');
    Ok(PathBuf::from(&path[from..]))
}

/// With `%20` and the like undone.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        rest = after;
        if first != b'%' {
            bytes.push(first);
            continue;
        }
        let (digits, after) = after.split_first_chunk::<2>()?;
        bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
        rest = after;
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations_of_the_forms_that_hosts_use() {
        for (uri, path) in [
            ("file:///tmp/fmu/resources", "/tmp/fmu/resources"),
            ("file:/tmp/fmu/resources", "/tmp/fmu/resources"),
            ("FILE://localhost/tmp/a%20b%C3%A9/resources", "/tmp/a bé/resources"),
            ("/tmp/fmu/resources", "/tmp/fmu/resources"),
        ] {
            assert_eq!(from_uri(uri), Ok(PathBuf::from(path)), "{uri}");
        }
        for uri in ["http://host/resources", "file://server/share", "file:///tmp/%zz", "file:///a%2"] {
            assert!(from_uri(uri).is_err(), "{uri}");
        }
    }
}
