//! `ishigaki scenes`: what can be run by name.

use crate::failure::Failure;
use crate::{number, output};
use clap::Args;
use ishigaki_scenes::{Parameter, SceneInfo, list, named, scene_schema};
use serde_json::json;

#[derive(Args)]
pub struct Scenes {
    /// Write this scene as a scene file to stdout.
    name: Option<String>,
    /// A parameter of the scene, such as n=40.
    #[arg(long = "param", value_name = "KEY=NUMBER", value_parser = number::parameter, requires = "name")]
    parameters: Vec<(String, f64)>,
    /// The list as JSON.
    #[arg(long, conflicts_with_all = ["name", "schema"])]
    json: bool,
    /// The JSON Schema of scene files.
    #[arg(long, conflicts_with = "name")]
    schema: bool,
}

impl Scenes {
    pub fn execute(&self) -> Result<(), Failure> {
        let text = match &self.name {
            Some(name) => named(name, &self.parameters).map_err(Failure::input)?.to_json(),
            None if self.schema => format!("{:#}", scene_schema()),
            None if self.json => format!("{:#}", list_as_json()),
            None => list_as_text(),
        };
        output::print(text.trim_end())
    }
}

fn list_as_json() -> serde_json::Value {
    list().iter().map(scene_as_json).collect()
}

fn scene_as_json(scene: &SceneInfo) -> serde_json::Value {
    let parameter = |p: &Parameter| {
        json!({ "name": p.name, "default": p.default, "least": p.range.0, "most": p.range.1, "unit": p.unit,
                "whole": p.whole, "summary": p.doc })
    };
    let parameters: Vec<_> = scene.parameters.iter().map(parameter).collect();
    json!({ "name": scene.name, "summary": scene.summary, "parameters": parameters })
}

fn list_as_text() -> String {
    let width = list().iter().map(|scene| scene.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for scene in list() {
        text.push_str(&format!("{:width$}  {}\n", scene.name, scene.summary));
        for p in scene.parameters {
            let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
            let (least, most) = p.range;
            let line = format!("--param {}={}{unit}  {} ({least} to {most})", p.name, p.default, p.doc);
            text.push_str(&format!("{:width$}    {line}\n", ""));
        }
    }
    text
}
