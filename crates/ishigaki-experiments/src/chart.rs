//! Charts as data: what is drawn is what is written to the CSV.

use std::fmt::Write;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Points joined by a line.
    Line,
    /// The same, dashed: predictions, and what others say.
    Dashed,
    /// Points joined by a line, each marked.
    Dotted,
    /// Points alone.
    Points,
    /// A dashed line in the color of the series before it: what was predicted for it.
    Law,
}

/// Points with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// For the legend.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// (x, y) in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// A straight line across a chart, such as a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// In the unit of the axis it is on.
    pub value: f64,
    /// Written beside it.
    pub label: String,
}

/// What a chart shows.
#[derive(Clone, Debug)]
pub enum Content {
    /// Curves over a number.
    Curves(Vec<Series>),
    /// Groups of bars: each group's name and one value for each of the names.
    Bars {
        /// Of the bars in each group, for the legend.
        names: Vec<String>,
        /// A name and as many values as `names`.
        groups: Vec<(String, Vec<f64>)>,
    },
    /// A table whose cells are colored by their value: the darker, the worse.
    Table {
        /// Of the rows, from the top.
        rows: Vec<String>,
        /// Of the columns.
        columns: Vec<String>,
        /// Value and text of each cell, row by row.
        cells: Vec<Vec<(f64, String)>>,
        /// From a value to how dark its cell is; only the order and the ratios of distances count.
        shade: fn(f64) -> f64,
    },
}

/// One chart of an experiment's plot.
#[derive(Clone, Debug)]
pub struct Chart {
    pub(crate) title: String,
    pub(crate) x_label: String,
    pub(crate) y_label: String,
    pub(crate) log_x: bool,
    pub(crate) log_y: bool,
    pub(crate) y_range: Option<(f64, f64)>,
    pub(crate) levels: Vec<Level>,
    pub(crate) content: Content,
}

impl Chart {
    fn new(title: impl Into<String>, x_label: &str, y_label: &str, content: Content) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.to_string(),
            y_label: y_label.to_string(),
            log_x: false,
            log_y: false,
            y_range: None,
            levels: Vec::new(),
            content,
        }
    }

    /// Curves; the labels of the axes end in their units.
    pub fn curves(title: impl Into<String>, x_label: &str, y_label: &str) -> Self {
        Self::new(title, x_label, y_label, Content::Curves(Vec::new()))
    }

    /// Groups of bars, one bar in each for each of `names`.
    pub fn bars<S: Into<String>>(title: impl Into<String>, y_label: &str, names: impl IntoIterator<Item = S>) -> Self {
        let names = names.into_iter().map(Into::into).collect();
        Self::new(title, "", y_label, Content::Bars { names, groups: Vec::new() })
    }

    /// A table of colored cells.
    pub fn table<S: Into<String>>(
        title: impl Into<String>,
        value_label: &str,
        columns: impl IntoIterator<Item = S>,
    ) -> Self {
        let columns = columns.into_iter().map(Into::into).collect();
        Self::new(title, "", value_label, Content::Table { rows: Vec::new(), columns, cells: Vec::new(), shade: |v| v })
    }

    /// Both axes of curves, or the values of bars, are logarithmic where the argument says so.
    #[must_use]
    pub fn log(mut self, x: bool, y: bool) -> Self {
        (self.log_x, self.log_y) = (x, y);
        self
    }

    /// The ends of the y axis; points beyond them are not drawn.
    #[must_use]
    pub fn y_range(mut self, low: f64, high: f64) -> Self {
        self.y_range = Some((low, high));
        self
    }

    /// A line across the chart at this y.
    #[must_use]
    pub fn level(mut self, value: f64, label: impl Into<String>) -> Self {
        self.levels.push(Level { value, label: label.into() });
        self
    }

    /// A series of a chart of curves.
    #[must_use]
    pub fn series(mut self, name: impl Into<String>, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        if let Content::Curves(series) = &mut self.content {
            series.push(Series { name: name.into(), mark, points });
        }
        self
    }

    /// A line of a chart of curves.
    #[must_use]
    pub fn line(self, name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        self.series(name, Mark::Line, points)
    }

    /// A group of a chart of bars.
    #[must_use]
    pub fn group(mut self, name: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        if let Content::Bars { groups, .. } = &mut self.content {
            groups.push((name.into(), values.into_iter().collect()));
        }
        self
    }

    /// How dark a cell of a table is, from its value.
    #[must_use]
    pub fn shade(mut self, darkness: fn(f64) -> f64) -> Self {
        if let Content::Table { shade, .. } = &mut self.content {
            *shade = darkness;
        }
        self
    }

    /// A row of a table: value and text of each cell.
    #[must_use]
    pub fn row(mut self, name: impl Into<String>, values: impl IntoIterator<Item = (f64, String)>) -> Self {
        if let Content::Table { rows, cells, .. } = &mut self.content {
            rows.push(name.into());
            cells.push(values.into_iter().collect());
        }
        self
    }
}

/// All data of the charts, one line for each value: chart, series, what x is, x, what y is, y.
pub fn csv(charts: &[Chart]) -> String {
    let mut text = String::from("chart,series,x_label,x,y_label,y\n");
    for chart in charts {
        // Nine digits are more than f32 has.
        let number = |v: f64| {
            if v == 0.0 || !v.is_finite() {
                v.to_string()
            } else {
                format!("{v:.8e}").parse::<f64>().unwrap_or(v).to_string()
            }
        };
        let mut line = |series: &str, x: &str, y: f64| {
            let fields = [&chart.title, series, &chart.x_label, x, &chart.y_label].map(quoted);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{},{}", fields.join(","), number(y));
        };
        match &chart.content {
            Content::Curves(series) => {
                for s in series {
                    s.points.iter().for_each(|(x, y)| line(&s.name, &number(*x), *y));
                }
            }
            Content::Bars { names, groups } => {
                for (group, values) in groups {
                    names.iter().zip(values).for_each(|(name, value)| line(name, group, *value));
                }
            }
            Content::Table { rows, columns, cells, .. } => {
                for (row, values) in rows.iter().zip(cells) {
                    columns.iter().zip(values).for_each(|(column, (value, _))| line(column, row, *value));
                }
            }
        }
    }
    text
}

/// RFC 4180: quotes around fields that need them.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_has_a_line_for_each_value() {
        let charts = [
            Chart::curves("Fall, \"free\"", "time, s", "y, m").line("a", vec![(0.0, 1.0), (0.5, f64::NAN)]),
            Chart::bars("Bars", "m", ["p", "q"]).group("g", [1.0, 2.0]),
            Chart::table("T", "mm", ["c"]).row("r", [(3.0, "three".to_string())]),
        ];
        let text = csv(&charts);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 1 + 2 + 2 + 1);
        assert_eq!(lines[1], "\"Fall, \"\"free\"\"\",a,\"time, s\",0,\"y, m\",1");
        assert_eq!(lines[3], "Bars,p,,g,m,1");
        assert_eq!(lines[5], "T,c,,r,mm,3");
    }
}
