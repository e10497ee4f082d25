//! One page with every plot and every verdict.

use crate::talk::{Proof, ROWS};
use crate::verdict::{Expected, Figure, Verdict, short};
use crate::{Experiment, talk};
use std::fmt::Write;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 \
    1rem;color:#222} img{width:100%;height:auto;border:1px solid \
    #ddd}table{border-collapse:collapse;margin:.5rem 0} td,th{padding:.15rem .7rem .15rem \
    0;text-align:left;vertical-align:top}.no{color:#b00020;font-weight:600} \
    .yes{color:#00694a}section{margin:3rem 0}a{color:#0058a3}";

/// HTML that shows `NAME.svg` of each experiment beside it. Experiments that are missing are left out.
pub fn page(results: &[(&Experiment, &Verdict)]) -> String {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
            content=\"width=device-width\">\n <title>Ishigaki: the talk as a \
            laboratory</title>\n<style>{STYLE}</style>\n<h1>The talk as a laboratory</h1>\n <p>One experiment \
            for each claim of the talk, run on the engine. The talk says, predicted, measured; where they \
            differ, the note says why.</p>\n"
    );
    html.push_str(&overview(results));
    for (experiment, verdict) in results {
        html.push_str(&section(experiment, verdict));
    }
    html.push_str(&rows());
    html.push_str("</html>\n");
    html
}

fn overview(results: &[(&Experiment, &Verdict)]) -> String {
    let mut html = String::from("<table>\n<tr><th>experiment<th>rows<th>verdict</tr>\n");
    for (experiment, verdict) in results {
        let name = experiment.name;
        let rows = experiment.rows.join(", ");
        let _ =
            writeln!(html, "<tr><td><a href=\"#{name}\">{name}</a><td>{rows}<td>{}</tr>", outcome(verdict.agrees()));
    }
    html + "</table>\n"
}

fn outcome(agrees: bool) -> &'static str {
    if agrees { "<span class=\"yes\">they agree</span>" } else { "<span class=\"no\">they differ</span>" }
}

fn section(experiment: &Experiment, verdict: &Verdict) -> String {
    let name = experiment.name;
    let techniques: Vec<String> = experiment
        .rows
        .iter()
        .filter_map(|id| talk::find(id))
        .map(|row| format!("{} {}", row.id, escaped(row.technique)))
        .collect();
    let mut html = format!(
        "<section id=\"{name}\">\n<h2>{name}</h2>\n<p>{} <em>{}</em></p>\n<p><strong>The talk says:</strong> \
            {}.</p>\n",
        escaped(experiment.title),
        techniques.join("; "),
        escaped(verdict.talk)
    );
    html.push_str("<table>\n<tr><th>figure<th>predicted<th>measured<th></tr>\n");
    for figure in &verdict.figures {
        html.push_str(&line(figure));
    }
    let _ = write!(html, "</table>\n<p>{} {}</p>\n", outcome(verdict.agrees()), escaped(&verdict.note));
    let _ = write!(
        html,
        "<a href=\"{name}.svg\"><img src=\"{name}.svg\" alt=\"Plot of {name}\" loading=\"lazy\"></a>\n <p><a \
            href=\"{name}.csv\">data</a> · <a href=\"{name}.png\">PNG</a></p>\n</section>\n"
    );
    html
}

fn line(figure: &Figure) -> String {
    let unit = escaped(figure.unit);
    let predicted = match figure.expected {
        Expected::Open => "–".to_string(),
        expected => format!("{expected} {unit}"),
    };
    let mark = if figure.holds() { "<span class=\"yes\">✓</span>" } else { "<span class=\"no\">differs</span>" };
    let mark = if figure.expected == Expected::Open { "" } else { mark };
    let (what, measured) = (escaped(&figure.what), short(figure.measured));
    format!("<tr><td>{what}<td>{predicted}<td>{measured} {unit}<td>{mark}</tr>\n")
}

/// The rows of the talk and where each is put to the test.
fn rows() -> String {
    let mut html = String::from("<h2 id=\"rows\">Rows of the talk</h2>\n<table>\n");
    for row in ROWS {
        let proof = match row.proof {
            Proof::Experiments(names) => {
                names.iter().map(|n| format!("<a href=\"#{n}\">{n}</a>")).collect::<Vec<_>>().join(", ")
            }
            Proof::Test(test) => format!("a definition; test <code>{}</code>", escaped(test)),
        };
        let _ = writeln!(html, "<tr><td>{}<td>{}<td>{proof}</tr>", row.id, escaped(row.technique));
    }
    html + "</table>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
