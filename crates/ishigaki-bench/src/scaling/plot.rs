//! The series as a picture: µs for a body over what grows, both on logarithmic axes; a panel for each kind of axis.

use super::report::{Row, with_threads};
use super::{Axis, distinct};
use crate::plot::{COLORS, escaped};
use std::fmt::Write;

/// Pixels.
const LEFT: f64 = 60.0;
const TOP: f64 = 50.0;
const WIDTH: f64 = 380.0;
const HEIGHT: f64 = 340.0;
const LEGEND: f64 = 18.0;

/// A rectangle with axes.
struct Panel {
    left: f64,
    x: Range,
    y: Range,
}

/// Powers of ten that a logarithmic axis begins and ends with.
#[derive(Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        // Nothing to show: any range will do.
        if high <= 0.0 || low <= 0.0 {
            return Self { low: 0.0, high: 1.0 };
        }
        let low = low.log10().floor();
        Self { low, high: high.log10().ceil().max(low + 1.0) }
    }

    fn part(self, value: f64) -> f64 {
        (value.log10() - self.low) / (self.high - self.low)
    }

    /// 1, 2 and 5 times each power of ten; whether it is the power itself.
    fn ticks(self) -> Vec<(f64, bool)> {
        let powers = (self.low as i32)..=(self.high as i32);
        let all = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|digit| (digit * 10_f64.powi(power), digit == 1.0)));
        all.filter(|(value, _)| self.part(*value) < 1.0 + 1e-9).collect()
    }
}

impl Panel {
    fn x(&self, value: f64) -> f64 {
        self.left + WIDTH * self.x.part(value)
    }

    fn y(&self, value: f64) -> f64 {
        TOP + HEIGHT * (1.0 - self.y.part(value))
    }

    fn draw_axes(&self, svg: &mut String, label: &str) {
        let (bottom, right) = (TOP + HEIGHT, self.left + WIDTH);
        for (value, power) in self.x.ticks() {
            let (at, color) = (self.x(value), if power { "#bbbbbb" } else { "#eeeeee" });
            let _ = write!(svg, "<path d=\"M{at:.1} {TOP}V{bottom}\" stroke=\"{color}\"/>");
            if power {
                let _ =
                    write!(svg, "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{value}</text>", bottom + 16.0);
            }
        }
        for (value, power) in self.y.ticks() {
            let (at, color) = (self.y(value), if power { "#bbbbbb" } else { "#eeeeee" });
            let _ = write!(svg, "<path d=\"M{} {at:.1}H{right}\" stroke=\"{color}\"/>", self.left);
            let (x, y) = (self.left - 6.0, at + 4.0);
            let _ = write!(svg, "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{}</text>", short(value));
        }
        let (middle, y) = (self.left + 0.5 * WIDTH, bottom + 34.0);
        let _ = writeln!(svg, "<text x=\"{middle}\" y=\"{y}\" text-anchor=\"middle\">{label}</text>");
    }

    fn draw_line(&self, svg: &mut String, points: &[(f64, f64)], style: &Style) {
        let places = points.iter().map(|&(x, y)| (self.x(x), self.y(y)));
        let path: Vec<String> = places.clone().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = write!(svg, "<polyline points=\"{}\" {}/>", path.join(" "), style.stroke());
        places.for_each(|(x, y)| style.draw_dot(svg, x, y));
        svg.push('\n');
    }
}

/// 0.05 without a tail of digits that binary numbers have.
fn short(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

/// Color by series, dash by threads, dot by engine.
struct Style {
    color: &'static str,
    dash: usize,
    dot: usize,
}

impl Style {
    fn stroke(&self) -> String {
        let dashes = ["none", "5 3", "2 2", "8 2 2 2"];
        let dash = dashes[self.dash % dashes.len()];
        format!("fill=\"none\" stroke=\"{}\" stroke-width=\"2\" stroke-dasharray=\"{dash}\"", self.color)
    }

    fn draw_dot(&self, svg: &mut String, x: f64, y: f64) {
        // The first engine's dots are full, the others' white with a rim of their form.
        let fill = if self.dot == 0 { self.color } else { "white" };
        let form = match self.dot {
            0 | 1 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\""),
            2 => format!("<rect x=\"{:.1}\" y=\"{:.1}\" width=\"7\" height=\"7\"", x - 3.5, y - 3.5),
            _ => format!("<path d=\"M{x:.1} {:.1}l4 7h-8z\"", y - 4.0),
        };
        let _ = write!(svg, "{form} fill=\"{fill}\" stroke=\"{}\"/>", self.color);
    }
}

/// An SVG of all rows that have a time.
pub fn draw(rows: &[Row]) -> String {
    let shown: Vec<&Row> = rows.iter().filter(|r| r.us_per_body.is_some_and(|us| us > 0.0)).collect();
    let kinds = [(Axis::Bodies, "bodies in the world"), (Axis::IslandSize, "bodies in an island")];
    let present: Vec<_> = kinds.into_iter().filter(|(axis, _)| shown.iter().any(|r| r.axis == *axis)).collect();
    let lines = distinct(shown.iter().map(|r| r.line()));
    let width = LEFT + (WIDTH + LEFT) * present.len().max(1) as f64;
    let height = TOP + HEIGHT + 56.0 + LEGEND * lines.len().div_ceil(2 * present.len().max(1)) as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"10\" y=\"20\" font-size=\"14\">Time of a step for each body, µs: median of turns</text>\n"
    );
    let style = styles(&shown);
    for (k, (axis, label)) in present.iter().enumerate() {
        let here: Vec<&Row> = shown.iter().copied().filter(|r| r.axis == *axis).collect();
        let panel = Panel {
            left: LEFT + (WIDTH + LEFT) * k as f64,
            x: Range::of(here.iter().map(|r| f64::from(r.number))),
            y: Range::of(here.iter().filter_map(|r| r.us_per_body)),
        };
        panel.draw_axes(&mut svg, label);
        for line in &lines {
            let of_line = here.iter().filter(|r| r.line() == *line);
            let points: Vec<(f64, f64)> = of_line.filter_map(|r| Some((f64::from(r.number), r.us_per_body?))).collect();
            panel.draw_line(&mut svg, &points, &style(*line));
        }
    }
    draw_legend(&mut svg, &lines, 2 * present.len().max(1), &style);
    svg.push_str("</svg>\n");
    svg
}

type Line<'a> = (&'a str, &'a str, u32);

fn styles<'a>(rows: &[&'a Row]) -> impl Fn(Line<'a>) -> Style {
    let series = distinct(rows.iter().map(|r| r.series.as_str()));
    let engines = distinct(rows.iter().map(|r| r.engine.as_str()));
    let threads = distinct(rows.iter().map(|r| r.threads));
    move |line| Style {
        color: COLORS[series.iter().position(|s| *s == line.0).unwrap_or(0) % COLORS.len()],
        dot: engines.iter().position(|e| *e == line.1).unwrap_or(0),
        dash: threads.iter().position(|t| *t == line.2).unwrap_or(0),
    }
}

fn draw_legend<'a>(svg: &mut String, lines: &[Line<'a>], columns: usize, style: &impl Fn(Line<'a>) -> Style) {
    for (i, &line) in lines.iter().enumerate() {
        let (x, y) = (20.0 + 210.0 * (i % columns) as f64, TOP + HEIGHT + 56.0 + LEGEND * (i / columns) as f64);
        let style = style(line);
        let _ = write!(svg, "<path d=\"M{x} {y}h30\" {}/>", style.stroke());
        style.draw_dot(svg, x + 15.0, y);
        let (series, engine, threads) = line;
        let text = format!("{series}, {engine}, {}", with_threads(threads));
        let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\">{}</text>", x + 38.0, y + 4.0, escaped(&text));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_powers_of_ten_and_places_are_logarithmic() {
        let range = Range::of([300.0, 5000.0].into_iter());
        assert_eq!((range.low, range.high), (2.0, 4.0));
        assert!((range.part(1000.0) - 0.5).abs() < 1e-12);
        assert_eq!(range.ticks().len(), 7);
        let one = Range::of([10.0].into_iter());
        assert_eq!((one.low, one.high), (1.0, 2.0));
        assert_eq!(Range::of(std::iter::empty()).ticks().len(), 4);
    }
}
