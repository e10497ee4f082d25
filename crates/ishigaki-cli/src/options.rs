//! `ishigaki options`: what `run --set` can set.

use crate::failure::Failure;
use crate::output;
use ishigaki::WorldOptions;
use ishigaki_scenes::list_options;

pub fn execute() -> Result<(), Failure> {
    let options = list_options(&WorldOptions::default());
    let width = options.iter().map(|(path, _)| path.len()).max().unwrap_or(0);
    let lines: Vec<String> = options.iter().map(|(path, value)| format!("{path:width$}  {value}")).collect();
    output::print(&lines.join("\n"))
}
