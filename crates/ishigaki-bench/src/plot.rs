//! The ratios as a picture: a dot for the median and a line for the spread, by scene and engine, on a logarithmic axis.

use crate::report::{REFERENCE, Row};
use std::fmt::Write;

/// Okabe and Ito's colors, told apart by everyone.
pub const COLORS: [&str; 6] = ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
/// Pixels.
const LABELS: f64 = 170.0;
const WIDTH: f64 = 900.0;
const ROW: f64 = 13.0;
const TOP: f64 = 56.0;

/// An SVG of all rows that have a ratio.
pub fn draw(rows: &[Row]) -> String {
    let shown: Vec<&Row> = rows.iter().filter(|r| r.ratio_to_box3d.is_some() && r.engine != REFERENCE).collect();
    let mut engines: Vec<&str> = Vec::new();
    let mut scenes: Vec<&str> = Vec::new();
    for row in &shown {
        if !engines.contains(&row.engine.as_str()) {
            engines.push(&row.engine);
        }
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    let values = || shown.iter().flat_map(|r| [r.ratio_low, r.ratio_high]).flatten().filter(|v| v.is_finite());
    let low = values().fold(0.5, f64::min).log10().floor();
    let high = values().fold(2.0, f64::max).log10().ceil().max(low + 1.0);
    let x = |ratio: f64| LABELS + (WIDTH - LABELS - 20.0) * (ratio.max(1e-9).log10() - low) / (high - low);
    let group = ROW * engines.len() as f64 + 10.0;
    let bottom = TOP + group * scenes.len() as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{:.0}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"10\" y=\"18\" font-size=\"14\">Time of a step over Box3D's in the same turns: median, 16th to 84th \
         percentile</text>\n",
        bottom + 40.0
    );
    axis(&mut svg, low as i32, high as i32, bottom, &x);
    for (k, engine) in engines.iter().enumerate() {
        let (left, color) = (LABELS + 110.0 * k as f64, COLORS[k % COLORS.len()]);
        let _ = writeln!(svg, "<circle cx=\"{left}\" cy=\"34\" r=\"4\" fill=\"{color}\"/>");
        let _ = writeln!(svg, "<text x=\"{}\" y=\"38\">{}</text>", left + 9.0, escaped(engine));
    }
    for (i, scene) in scenes.iter().enumerate() {
        let top = TOP + group * i as f64;
        let _ = writeln!(svg, "<text x=\"10\" y=\"{:.1}\">{}</text>", top + 0.5 * group, escaped(scene));
        for row in shown.iter().filter(|r| r.scene == **scene) {
            let k = engines.iter().position(|e| *e == row.engine).unwrap_or(0);
            let (y, color) = (top + ROW * (k as f64 + 0.8), COLORS[k % COLORS.len()]);
            if let (Some(median), Some(from), Some(to)) = (row.ratio_to_box3d, row.ratio_low, row.ratio_high) {
                let (from, to) = (x(from), x(to));
                let _ = writeln!(
                    svg,
                    "<line x1=\"{from:.1}\" y1=\"{y:.1}\" x2=\"{to:.1}\" y2=\"{y:.1}\" stroke=\"{color}\" \
                     stroke-width=\"2\"/><circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{color}\"/>",
                    x(median)
                );
            }
        }
    }
    svg.push_str("</svg>\n");
    svg
}

/// Lines at 1, 2 and 5 times each power of ten; that of Box3D itself is black.
fn axis(svg: &mut String, low: i32, high: i32, bottom: f64, x: &dyn Fn(f64) -> f64) {
    for power in low..=high {
        for digit in [1.0, 2.0, 5.0] {
            let ratio = digit * 10_f64.powi(power);
            if power == high && digit > 1.0 {
                break;
            }
            let (at, color) = (x(ratio), if ratio == 1.0 { "#000000" } else { "#dddddd" });
            let _ = writeln!(
                svg,
                "<line x1=\"{at:.1}\" y1=\"{TOP}\" x2=\"{at:.1}\" y2=\"{bottom:.1}\" stroke=\"{color}\"/>\
                 <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{ratio}</text>",
                bottom + 16.0
            );
        }
    }
}

/// Text between tags.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
