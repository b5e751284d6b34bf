//! The guide as data: chapters of its summary; code blocks, links and anchors of a page.

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A code block between fences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// First word behind the fence, as `sh`; empty without one.
    pub language: String,
    /// The words behind it, which no reader sees: the name of a file, or how a test treats the block.
    pub note: String,
    /// The text.
    pub text: String,
    /// Line of the fence, from 1.
    pub line: usize,
}

/// A link or a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// Address or path, as written.
    pub target: String,
    /// Line, from 1.
    pub line: usize,
}

/// A page, as far as tests look at it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Markdown {
    /// Its code blocks, in order.
    pub blocks: Vec<Block>,
    /// Its links and pictures, in order.
    pub links: Vec<Link>,
    /// The names by which its headings are linked to, without `#`.
    pub anchors: Vec<String>,
    /// Its headings of the first level.
    pub titles: Vec<String>,
    /// Code inside a line, in order, with its line.
    pub spans: Vec<(String, usize)>,
}

/// Name of a heading in links, as mdBook and GitHub make it: letters and digits small, blanks as `-`, the rest left out.
fn anchor(heading: &str) -> String {
    let kept = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | ' ');
    let kept = heading.trim().chars().filter(|c| kept(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

impl Markdown {
    /// Reads Markdown.
    #[must_use]
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "most of what Markdown has is no concern of the tests"
    )]
    pub fn new(markdown: &str) -> Self {
        let mut page = Self::default();
        let mut heading: Option<(bool, String)> = None;
        let mut block: Option<Block> = None;
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        for (event, range) in Parser::new_ext(markdown, Options::ENABLE_TABLES).into_offset_iter() {
            let line = 1 + markdown[..range.start].matches('\n').count();
            match event {
                Event::Start(Tag::Heading { level, .. }) => {
                    heading = Some((level as usize == 1, String::new()));
                }
                Event::End(TagEnd::Heading(_)) => {
                    if let Some((first_level, text)) = heading.take() {
                        let name = anchor(&text);
                        let again = seen.entry(name.clone()).or_insert(0);
                        page.anchors.push(match *again {
                            0 => name,
                            n => format!("{name}-{n}"),
                        });
                        *again += 1;
                        if first_level {
                            page.titles.push(text);
                        }
                    }
                }
                Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) => {
                    let (language, note) = info.split_once(' ').unwrap_or((&info, ""));
                    block = Some(Block {
                        language: language.to_owned(),
                        note: note.trim().to_owned(),
                        text: String::new(),
                        line,
                    });
                }
                Event::End(TagEnd::CodeBlock) => page.blocks.extend(block.take()),
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    let target = dest_url.into_string();
                    page.links.push(Link { target, line });
                }
                Event::Text(text) => match (&mut block, &mut heading) {
                    (Some(block), _) => block.text.push_str(&text),
                    (None, Some((_, heading))) => heading.push_str(&text),
                    (None, None) => {}
                },
                Event::Code(code) => match &mut heading {
                    Some((_, heading)) => heading.push_str(&code),
                    None => page.spans.push((code.into_string(), line)),
                },
                _ => {}
            }
        }
        page
    }
}

/// The folder of the guide's pages.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/src")
}

/// Files of the chapters, in the order of the summary; empty for a chapter that is announced and not there yet.
///
/// # Panics
/// If there is no summary.
#[must_use]
pub fn chapters() -> Vec<String> {
    let summary = std::fs::read_to_string(folder().join("SUMMARY.md")).expect("a summary");
    let links = Markdown::new(&summary).links.into_iter();
    links.map(|link| link.target).collect()
}

/// The text of a chapter, or of the file that it includes.
///
/// # Panics
/// If it is not there.
#[must_use]
pub fn chapter(file: &str) -> String {
    let path = folder().join(file);
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let included = text.trim_end().strip_prefix("{{#include ");
    match included.and_then(|rest| rest.strip_suffix("}}")) {
        Some(included) => chapter(included),
        None => text,
    }
}
