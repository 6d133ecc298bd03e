//! A view in space inside a page.

use serde_json::{Value, json};

use super::encode::Arrays;
use crate::base64;
use crate::scene::{Body, Scene};

/// three.js, compressed; the page unpacks it. See assets/README.md.
const THREE: &[u8] = include_bytes!("assets/three.min.js.gz");

/// The scripts that views need, once for a page.
pub(super) fn scripts() -> String {
    format!(
        "<script type=\"text/plain\" id=\"three\">{}</script>\n<script>{}</script>\n<script>{}</script>\n",
        base64::encode(THREE),
        include_str!("assets/stage.js"),
        include_str!("assets/view.js")
    )
}

/// Indices of arrays and names, as `view.js` expects them.
pub(super) fn encode(scene: &Scene, arrays: &mut Arrays) -> Value {
    let segments = scene.lines.iter().flat_map(|line| line.windows(2)).flatten();
    json!({
        "positions": arrays.add(scene.positions.iter().copied()),
        "segments": arrays.add(segments.map(|&node| f64::from(node))),
        "bodies": scene.bodies.iter().map(|body| encode_body(body, arrays)).collect::<Vec<_>>(),
        "modes": {
            "names": scene.modes.names,
            "shapes": arrays.add(scene.modes.shapes.iter().copied()),
            "rigid": arrays.add(scene.modes.rigid.iter().copied()),
        },
    })
}

fn encode_body(body: &Body, arrays: &mut Arrays) -> Value {
    let mut add = |values: &[f64]| arrays.add(values.iter().copied());
    let points: Vec<Value> = body
        .points
        .iter()
        .map(|p| json!({ "name": p.name, "rest": p.rest, "displacement": add(&p.displacement) }))
        .collect();
    let arrows: Vec<Value> = body
        .arrows
        .iter()
        .map(|a| json!({ "moment": a.is_moment, "point": a.point, "vector": add(&a.vector) }))
        .collect();
    json!({
        "name": body.name,
        "t": add(&body.t),
        "origin": add(&body.origin),
        "attitude": add(&body.attitude),
        "shapes": add(&body.shapes),
        "amplitudes": add(&body.amplitudes),
        "points": points,
        "arrows": arrows,
    })
}
