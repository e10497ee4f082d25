//! XML as the importers read it: elements with their file and line, includes put in place, numbers checked.
//!
//! Elements lie in one flat list and name their children by index: any depth of nesting is read, walked and dropped
//! without recursion (readers that make a tree, `roxmltree` among them, overflow the stack at a few hundred levels in
//! debug builds). A number that is not finite is an error of the file.

use crate::error::SceneError;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files that include files … stop here.
const MAX_INCLUDE_DEPTH: usize = 32;
/// In all, so that files that include each other twice do not grow without end.
const MAX_INCLUDED_FILES: usize = 1000;
/// Beyond this a number cannot be meant.
const MAX_NUMBER: f64 = 1e20;
/// Elements of one model, its includes counted.
const MAX_ELEMENTS: usize = 2_000_000;

/// An element and where it stands.
#[derive(Debug)]
pub(crate) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<usize>,
    file: usize,
    line: u32,
}

impl Element {
    /// An attribute as it is written.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }
}

/// A document, its root first.
#[derive(Debug)]
pub(crate) struct Document {
    pub elements: Vec<Element>,
    files: Vec<String>,
}

/// Attributes by name: those of a default class.
pub(crate) type Defaults = BTreeMap<String, String>;

impl Document {
    /// Reads a document. With `include_from` each `<include file>` is replaced by the children of that file's root;
    /// its path is relative to `include_from`.
    pub fn parse(xml: &str, file: &str, include_from: Option<&Path>) -> Result<Self, SceneError> {
        let mut document = Self { elements: Vec::new(), files: Vec::new() };
        let mut reader = Reader { document: &mut document, include_from, open: Vec::new() };
        reader.append(None, xml, file)?;
        Ok(document)
    }

    pub fn root(&self) -> &Element {
        &self.elements[0]
    }

    pub fn element(&self, id: usize) -> &Element {
        &self.elements[id]
    }

    /// Children of an element, as indices.
    pub fn children(&self, id: usize) -> &[usize] {
        &self.elements[id].children
    }

    /// The first child with a tag.
    pub fn child(&self, id: usize, tag: &str) -> Option<usize> {
        self.children(id).iter().copied().find(|&c| self.elements[c].tag == tag)
    }

    /// All children with a tag of all of the root's children with another: sections may occur several times.
    pub fn in_sections(&self, section: &str) -> impl Iterator<Item = usize> {
        let section = section.to_owned();
        self.children(0)
            .iter()
            .filter(move |&&s| self.elements[s].tag == section)
            .flat_map(|&s| self.children(s).iter().copied())
    }

    /// `ant.xml:12`.
    pub fn place(&self, id: usize) -> String {
        let element = &self.elements[id];
        format!("{}:{}", self.files[element.file], element.line)
    }

    /// `ant.xml:12: <geom name="foot">`.
    pub fn describe(&self, id: usize) -> String {
        let element = &self.elements[id];
        let name = element.attribute("name").map(|n| format!(" name=\"{n}\"")).unwrap_or_default();
        format!("{}: <{}{name}>", self.place(id), element.tag)
    }

    pub fn error(&self, id: usize, message: impl std::fmt::Display) -> SceneError {
        SceneError::invalid(self.describe(id), message.to_string())
    }

    /// The attributes of an element over those of its default class.
    pub fn attributes<'a>(&'a self, id: usize, defaults: Option<&'a Defaults>) -> Attributes<'a> {
        Attributes { document: self, id, defaults }
    }
}

struct Reader<'a> {
    document: &'a mut Document,
    include_from: Option<&'a Path>,
    /// Files being read: the one that includes, the one it includes …
    open: Vec<PathBuf>,
}

impl Reader<'_> {
    fn append(&mut self, parent: Option<usize>, xml: &str, file: &str) -> Result<(), SceneError> {
        let file_id = self.document.files.len();
        self.document.files.push(file.to_owned());
        let mut reader = quick_xml::Reader::from_str(xml);
        let mut lines = Lines { xml: xml.as_bytes(), counted: 0, line: 1 };
        // Elements that wait for their end; an included file's root stands for the element it is put into.
        let mut open: Vec<usize> = Vec::new();
        let mut root_read = false;
        loop {
            let start = reader.buffer_position() as usize;
            let event = reader.read_event();
            let line = lines.at(start);
            let broken = |e: &dyn std::fmt::Display| {
                SceneError::invalid(format!("{file}:{line}"), format!("not well-formed XML: {e}"))
            };
            match event.map_err(|e| broken(&e))? {
                event @ (Event::Start(_) | Event::Empty(_)) => {
                    let (Event::Start(tag) | Event::Empty(tag)) = &event else { continue };
                    let is_root = open.is_empty();
                    if is_root && root_read {
                        return Err(broken(&"more than one root element"));
                    }
                    root_read = true;
                    let id = match parent {
                        Some(parent) if is_root => parent,
                        _ => self.element(tag, open.last().copied(), file_id, line).map_err(|e| match e {
                            Refused::Xml(message) => broken(&message),
                            Refused::Scene(error) => error,
                        })?,
                    };
                    if matches!(event, Event::Start(_)) {
                        open.push(id);
                    }
                }
                Event::End(_) => {
                    open.pop();
                }
                Event::Eof => {
                    if let Some(&id) = open.last() {
                        let tag = &self.document.elements[id].tag;
                        return Err(broken(&format!("<{tag}> has no end")));
                    }
                    return if root_read { Ok(()) } else { Err(broken(&"there is no element")) };
                }
                _ => {}
            }
        }
    }

    /// Takes in an element; of an include, what it stands for.
    fn element(&mut self, tag: &BytesStart, parent: Option<usize>, file: usize, line: u32) -> Result<usize, Refused> {
        if self.document.elements.len() >= MAX_ELEMENTS {
            return Err(Refused::Xml(format!("more than {MAX_ELEMENTS} elements")));
        }
        let name = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|e| Refused::Xml(e.to_string()))?;
            let value = attribute.unescape_value().map_err(|e| Refused::Xml(e.to_string()))?;
            attributes.push((name(attribute.key.local_name().as_ref()), value.into_owned()));
        }
        let id = self.document.elements.len();
        let tag = name(tag.local_name().as_ref());
        let include = tag == "include" && self.include_from.is_some();
        self.document.elements.push(Element { tag, attributes, children: Vec::new(), file, line });
        if include {
            self.include(id, parent).map_err(Refused::Scene)?;
        } else if let Some(parent) = parent {
            self.document.elements[parent].children.push(id);
        }
        Ok(id)
    }

    fn include(&mut self, id: usize, parent: Option<usize>) -> Result<(), SceneError> {
        let fail = |document: &Document, message: String| Err(document.error(id, message));
        let (Some(base), Some(parent)) = (self.include_from, parent) else {
            return fail(self.document, "an include cannot be the root".into());
        };
        let Some(name) = self.document.elements[id].attribute("file").map(str::to_owned) else {
            return fail(self.document, "an include needs the attribute `file`".into());
        };
        let path = base.join(&name);
        if self.open.contains(&path) {
            return fail(self.document, format!("{name} includes itself"));
        }
        if self.open.len() >= MAX_INCLUDE_DEPTH || self.document.files.len() >= MAX_INCLUDED_FILES {
            let message = format!(
                "too many includes: at most {MAX_INCLUDE_DEPTH} inside each other, {MAX_INCLUDED_FILES} in all"
            );
            return fail(self.document, message);
        }
        let xml = match std::fs::read_to_string(&path) {
            Ok(xml) => xml,
            Err(e) => return fail(self.document, format!("cannot read {}: {e}", path.display())),
        };
        self.open.push(path);
        self.append(Some(parent), &xml, &name)?;
        self.open.pop();
        Ok(())
    }
}

enum Refused {
    Xml(String),
    Scene(SceneError),
}

/// Line numbers of places that are asked for in order.
struct Lines<'a> {
    xml: &'a [u8],
    counted: usize,
    line: u32,
}

impl Lines<'_> {
    fn at(&mut self, place: usize) -> u32 {
        let place = place.clamp(self.counted, self.xml.len());
        self.line += self.xml[self.counted..place].iter().filter(|&&b| b == b'\n').count() as u32;
        self.counted = place;
        self.line
    }
}

/// The attributes of one element over its defaults, read with their types.
#[derive(Clone, Copy)]
pub(crate) struct Attributes<'a> {
    pub document: &'a Document,
    pub id: usize,
    defaults: Option<&'a Defaults>,
}

impl<'a> Attributes<'a> {
    /// As it is written: on the element, else in its class.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        let own = self.document.element(self.id).attribute(name);
        own.or_else(|| self.defaults.and_then(|d| d.get(name)).map(String::as_str))
    }

    pub fn error(&self, name: &str, message: impl std::fmt::Display) -> SceneError {
        self.document.error(self.id, format!("{name}: {message}"))
    }

    /// Text that must be there.
    pub fn required(&self, name: &str) -> Result<&'a str, SceneError> {
        self.text(name).ok_or_else(|| self.error(name, "this attribute is missing"))
    }

    /// Between `least` and `most` numbers.
    pub fn list(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, SceneError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let mut numbers = Vec::new();
        for word in text.split_whitespace() {
            let number: f64 = word.parse().map_err(|_| self.error(name, format!("`{word}` is not a number")))?;
            // Greater numbers would overflow where they are multiplied.
            if !(number.is_finite() && number.abs() <= MAX_NUMBER) {
                return Err(self.error(name, format!("must be finite and within ±{MAX_NUMBER:e}, is {word}")));
            }
            numbers.push(number);
            if numbers.len() > most {
                break;
            }
        }
        if numbers.len() < least || numbers.len() > most {
            let expected = if least == most { format!("{least}") } else { format!("{least} to {most}") };
            return Err(self.error(name, format!("needs {expected} numbers, is `{}`", shortened(text))));
        }
        Ok(Some(numbers))
    }

    /// Exactly N numbers.
    pub fn array<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, SceneError> {
        Ok(self.list(name, N, N)?.and_then(|v| <[f64; N]>::try_from(v).ok()))
    }

    pub fn number(&self, name: &str) -> Result<Option<f64>, SceneError> {
        Ok(self.array::<1>(name)?.map(|[x]| x))
    }

    /// A number ≥ 0, 0 if it is not there.
    pub fn not_negative(&self, name: &str) -> Result<f64, SceneError> {
        let value = self.number(name)?.unwrap_or(0.0);
        if value < 0.0 { Err(self.error(name, format!("must be ≥ 0, is {value}"))) } else { Ok(value) }
    }

    /// A whole number; bit masks may be written as negative numbers.
    pub fn integer(&self, name: &str) -> Result<Option<i64>, SceneError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let parsed = text.trim().parse::<i64>();
        parsed.map(Some).map_err(|_| self.error(name, format!("`{}` is not a whole number", shortened(text))))
    }

    /// `true` or `false`.
    pub fn boolean(&self, name: &str) -> Result<Option<bool>, SceneError> {
        match self.text(name) {
            None => Ok(None),
            Some("true") => Ok(Some(true)),
            Some("false") => Ok(Some(false)),
            Some(other) => Err(self.error(name, format!("must be true or false, is `{}`", shortened(other)))),
        }
    }

    /// `true`, `false` or `auto` (`None`).
    pub fn tristate(&self, name: &str) -> Result<Option<bool>, SceneError> {
        if self.text(name) == Some("auto") { Ok(None) } else { self.boolean(name) }
    }
}

/// The start of a text, for messages.
pub(crate) fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
