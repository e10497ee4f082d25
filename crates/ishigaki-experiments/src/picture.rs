//! Charts drawn in one style, as SVG and PNG from the same scene: charts below each other, legends beside the data.

use crate::chart::{Chart, Content, Mark, Series};
use crate::verdict::short;
use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::plot::{ColorMap, LegendPosition, LineStyle};
use kuva::prelude::{BarPlot, Heatmap, Layout, LinePlot, Plot, ReferenceLine, ScatterPlot, TextAnnotation};
use kuva::render::figure::Figure;
use kuva::render::layout::TickFormat;
use std::sync::Arc;

/// Of a chart, pixels of the SVG.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 400.0;
/// Of a row of a table.
const ROW_HEIGHT: f64 = 30.0;
/// Pixels of the PNG for one of the SVG: sharp on dense screens too.
const PNG_SCALE: f32 = 1.5;
/// Okabe and Ito's colors, told apart by everyone; yellow is too light for lines. Then gray and brown.
const COLORS: [&str; 9] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#7f7f7f", "#8c4a1f"];
/// Of lines that say what is expected.
const LEVEL_COLOR: &str = "#666666";
/// More points than this cannot be told apart in the width of a chart.
const MOST_POINTS: usize = 2000;

/// SVG and PNG.
pub fn draw(title: &str, charts: &[Chart]) -> Result<(String, Vec<u8>), String> {
    if charts.is_empty() {
        return Err("there is no chart".to_string());
    }
    let mut figure = Figure::new(charts.len(), 1)
        .with_title(title)
        .with_title_size(18)
        .with_spacing(12.0)
        .with_padding(14.0)
        .with_cell_size(WIDTH, HEIGHT);
    for (i, chart) in charts.iter().enumerate() {
        if let Content::Table { rows, .. } = &chart.content {
            figure = figure.with_row_height(i, 110.0 + ROW_HEIGHT * rows.len() as f64);
        }
    }
    let (plots, layouts): (Vec<_>, Vec<_>) = charts.iter().map(drawn).unzip();
    let scene = figure.with_plots(plots).with_layouts(layouts).render();
    let png = PngBackend::new().with_scale(PNG_SCALE).render_scene(&scene)?;
    Ok((SvgBackend::new().render_scene(&scene), png))
}

fn drawn(chart: &Chart) -> (Vec<Plot>, Layout) {
    let plots = match &chart.content {
        Content::Curves(series) => curves(chart, series),
        Content::Bars { names, groups } => vec![bars(names, groups)],
        Content::Table { cells, shade, .. } => vec![table(cells, *shade)],
    };
    let mut layout = Layout::auto_from_plots(&plots)
        .with_title(&chart.title)
        .with_title_size(15)
        .with_label_size(13)
        .with_tick_size(12)
        .with_body_size(12)
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_box(false);
    if !chart.x_label.is_empty() {
        layout = layout.with_x_label(&chart.x_label);
    }
    if chart.log_x {
        layout = layout.with_log_x();
    }
    if chart.log_y {
        layout = layout.with_log_y();
    }
    if chart.log_x {
        layout = layout.with_x_tick_format(ticks());
    }
    if chart.log_y {
        layout = layout.with_y_tick_format(ticks());
    }
    layout = with_ends(layout, chart);
    if let Some((low, high)) = chart.y_range {
        layout = layout.with_y_axis_min(low).with_y_axis_max(high).with_clamp_y_axis();
    }
    for level in &chart.levels {
        let line = ReferenceLine::horizontal(level.value).with_color(LEVEL_COLOR).with_label(&level.label);
        layout = layout.with_reference_line(line);
    }
    match &chart.content {
        Content::Curves(_) => (plots, layout.with_y_label(&chart.y_label)),
        Content::Bars { .. } => (plots, layout.with_y_label(&chart.y_label)),
        Content::Table { rows, columns, cells, .. } => (plots, with_texts(layout, rows, columns, cells)),
    }
}

/// Ticks of logarithmic axes, all in one way.
fn ticks() -> TickFormat {
    TickFormat::Custom(Arc::new(|value| {
        let plain = (1e-3 * 0.999..1e5).contains(&value.abs());
        if plain { short(value) } else { format!("{value:.0e}") }
    }))
}

/// Curves end where their data end; bars on a logarithmic axis start a decade below the least of them.
fn with_ends(layout: Layout, chart: &Chart) -> Layout {
    match &chart.content {
        Content::Curves(series) => {
            let places = series.iter().flat_map(|s| &s.points).map(|p| p.0);
            let ends = places.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            // Room for half a mark.
            let has_marks = series.iter().any(|s| matches!(s.mark, Mark::Dotted | Mark::Points));
            match ends {
                (low, high) if low >= high => layout,
                (low, high) if chart.log_x => {
                    let room = (high / low).powf(0.02);
                    let start = if has_marks { low / room } else { low };
                    layout.with_x_axis_min(start).with_x_axis_max(high * room)
                }
                (low, high) => {
                    let span = high - low;
                    let room = if has_marks { 0.01 * span } else { 0.0 };
                    let start = if (0.0..0.3 * span).contains(&low) { 0.0 } else { low - room };
                    layout.with_x_axis_min(start).with_x_axis_max(high + 0.01 * span)
                }
            }
        }
        Content::Bars { groups, .. } if chart.log_y => {
            let least = groups.iter().flat_map(|g| &g.1).copied().filter(|v| *v > 0.0).fold(f64::MAX, f64::min);
            if least < f64::MAX { layout.with_y_axis_min(10_f64.powf(least.log10().floor() - 1.0)) } else { layout }
        }
        _ => layout,
    }
}

/// Each series in a color of its own, except laws, which have that of the series before them.
fn curves(chart: &Chart, series: &[Series]) -> Vec<Plot> {
    let (mut plots, mut colors) = (Vec::new(), COLORS.iter().cycle());
    let mut color = COLORS[0];
    for s in series {
        if s.mark != Mark::Law {
            color = colors.next().unwrap_or(&COLORS[0]);
        }
        plots.append(&mut curve(chart, s, color));
    }
    plots
}

/// A line, its marks, or both. What a logarithmic axis cannot show is left out.
fn curve(chart: &Chart, series: &Series, color: &str) -> Vec<Plot> {
    let (low, high) = chart.y_range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let visible = |(x, y): &(f64, f64)| {
        let on_axis = |log: bool, v: f64| v.is_finite() && (!log || v > 0.0);
        on_axis(chart.log_x, *x) && on_axis(chart.log_y, *y) && (low..=high).contains(y)
    };
    let points: Vec<(f64, f64)> = thinned(&series.points).into_iter().filter(visible).collect();
    if points.is_empty() {
        return Vec::new();
    }
    let marks = |named: bool| {
        let plot = ScatterPlot::new().with_data(points.clone()).with_color(color).with_size(4.0);
        Plot::Scatter(if named { plot.with_legend(&series.name) } else { plot })
    };
    let line = |style: LineStyle| {
        let plot = LinePlot::new().with_data(points.clone()).with_color(color).with_stroke_width(2.0);
        Plot::Line(plot.with_line_style(style).with_legend(&series.name))
    };
    match series.mark {
        Mark::Line => vec![line(LineStyle::Solid)],
        Mark::Dashed | Mark::Law => vec![line(LineStyle::Dashed)],
        Mark::Dotted => vec![line(LineStyle::Solid), marks(false)],
        Mark::Points => vec![marks(true)],
    }
}

/// Of each run of points the first, the lowest and the highest: no peak is lost.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let run = points.len().div_ceil(MOST_POINTS / 3);
    let mut kept = Vec::with_capacity(MOST_POINTS + 3);
    for part in points.chunks(run) {
        let by_y = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let mut chosen: Vec<(f64, f64)> =
            [part.first(), part.iter().min_by(by_y), part.iter().max_by(by_y)].into_iter().flatten().copied().collect();
        chosen.sort_by(|a, b| a.0.total_cmp(&b.0));
        chosen.dedup();
        kept.append(&mut chosen);
    }
    kept.extend(points.last());
    kept
}

fn bars(names: &[String], groups: &[(String, Vec<f64>)]) -> Plot {
    let mut plot = BarPlot::new();
    for (group, values) in groups {
        let colored = values.iter().copied().zip(COLORS.iter().copied().cycle());
        plot = plot.with_group(group.as_str(), colored);
    }
    if names.len() > 1 {
        plot = plot.with_legend(names.iter().map(String::as_str).collect());
    }
    Plot::Bar(plot)
}

/// From nearly white to orange: black text is readable on all of it.
fn shade(part: f64) -> String {
    let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 };
    let mix = |from: f64, to: f64| (from + (to - from) * part).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(250.0, 240.0), mix(252.0, 160.0), mix(255.0, 90.0))
}

fn table(cells: &[Vec<(f64, String)>], darkness: fn(f64) -> f64) -> Plot {
    let finite = cells.iter().flatten().map(|c| darkness(c.0)).filter(|v| v.is_finite());
    let (least, most) = finite.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
    let span = if most > least { most - least } else { 1.0 };
    // Not a number counts as the worst that there is; cells without text are empty.
    let part = |(value, text): &(f64, String)| {
        let dark = darkness(*value);
        if text.trim().is_empty() {
            0.0
        } else if dark.is_finite() {
            (dark - least) / span
        } else {
            1.0
        }
    };
    // Rows are counted from the bottom. The corners of the scale are fixed by `shade`.
    let data: Vec<Vec<f64>> = cells.iter().rev().map(|row| row.iter().map(part).collect()).collect();
    let greatest = data.iter().flatten().fold(0.0_f64, |m, v| m.max(*v));
    let map = ColorMap::Custom(Arc::new(move |t| shade(t * greatest)));
    Plot::Heatmap(Heatmap::new().with_data(data).with_color_map(map))
}

fn with_texts(layout: Layout, rows: &[String], columns: &[String], cells: &[Vec<(f64, String)>]) -> Layout {
    // Rows are counted from the bottom.
    let bottom_up = rows.iter().rev().cloned().collect();
    let mut layout = layout.with_x_categories(columns.to_vec()).with_y_categories(bottom_up);
    layout.show_colorbar = false;
    // Pixels over those of a row: the figure's height for it less what title and labels take.
    let down = 10.0 / (ROW_HEIGHT + 17.0 / cells.len().max(1) as f64);
    for (r, row) in cells.iter().enumerate() {
        for (c, (value, text)) in row.iter().enumerate() {
            let text = if text.is_empty() { short(*value) } else { text.clone() };
            // The library draws above the place it is given.
            let place = ((c + 1) as f64, (cells.len() - r) as f64 - down);
            layout = layout.with_annotation(TextAnnotation::new(text, place.0, place.1).with_font_size(12));
        }
    }
    layout
}
