//! A crate's source as a test of its structure needs it: which file defines which name, and which names a file uses.
//!
//! Rules:
//! - A module is its file; an inline `mod` belongs to the file it stands in.
//! - `pub use` hands a name on and is no import; a name so handed on stands for the file that defines it.
//! - What is built for tests only does not count, nor do comments and documentation.

#![expect(
    clippy::wildcard_enum_match_arm,
    reason = "the enums are syn's, which has forty kinds of expression"
)]

use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// What the sources of a crate say about each of its files, by the file's module: `a::b`, or `crate` for the root.
#[derive(Debug, Default)]
pub(crate) struct Source {
    /// The files of a module path: two where the system decides which is built.
    modules: BTreeMap<Vec<String>, Module>,
    /// Name of each file.
    pub(crate) files: Vec<File>,
}

/// A file.
#[derive(Debug, Default)]
pub(crate) struct File {
    /// Its module, `a::b`; of two files of one module the second in brackets.
    pub(crate) name: String,
    /// Names of macros that it calls.
    pub(crate) macros: BTreeSet<String>,
    /// Paths as they stand, `std::env::args`, with what `use` brings in put before the rest.
    pub(crate) paths: BTreeSet<String>,
    /// Texts between quotation marks.
    pub(crate) texts: Vec<String>,
    /// Methods that take finished sentences apart.
    pub(crate) edits: Vec<String>,
    /// Names of methods that are called without arguments.
    pub(crate) asked: BTreeSet<String>,
}

#[derive(Debug, Default)]
struct Module {
    files: BTreeSet<usize>,
    /// Where a name is defined here, by number of the file.
    items: BTreeMap<String, BTreeSet<usize>>,
    /// Names that `use` brings in: the full path as written.
    names: BTreeMap<String, Vec<Vec<String>>>,
    /// Modules of which all names are brought in.
    globs: Vec<Vec<String>>,
    /// Paths in code and in imports for oneself, each with the file it stands in.
    uses: Vec<(usize, Vec<String>)>,
}

impl Source {
    /// The files that define what a path names, seen from a module; none for what is of another crate.
    fn resolve(&self, module: &[String], path: &[String], depth: usize) -> BTreeSet<usize> {
        let mut at = module.to_vec();
        let mut rest = path;
        let mut anchored = false;
        while let [first, tail @ ..] = rest {
            match first.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => {
                    at.pop();
                }
                _ => break,
            }
            (rest, anchored) = (tail, true);
        }
        self.resolve_in(&at, rest, anchored, depth)
    }

    fn resolve_in(
        &self,
        at: &[String],
        rest: &[String],
        anchored: bool,
        depth: usize,
    ) -> BTreeSet<usize> {
        let none = BTreeSet::new();
        let (Some(module), [name, tail @ ..]) = (self.modules.get(at), rest) else {
            return none;
        };
        if depth > 20 {
            return none;
        }
        if let Some(files) = module.items.get(name) {
            return files.clone();
        }
        let child = [at, std::slice::from_ref(name)].concat();
        if !tail.is_empty() && self.modules.contains_key(&child) {
            return self.resolve_in(&child, tail, true, depth + 1);
        }
        if let Some(named) = module.names.get(name) {
            let whole = named.iter().map(|path| [path, tail].concat());
            // A crate of this name would be meant where a path names itself.
            let whole = whole.filter(|path| path.first() != Some(name));
            return whole
                .flat_map(|path| self.resolve(at, &path, depth + 1))
                .collect();
        }
        // The names of another crate are not ours, and would be sought through each glob again.
        let is_ours = |glob: &&Vec<String>| {
            let child = [at, &glob[..1]].concat();
            ["crate", "self", "super"].contains(&glob[0].as_str())
                || self.modules.contains_key(&child)
                || module.names.contains_key(&glob[0])
        };
        for glob in module.globs.iter().filter(is_ours) {
            let path = [glob, rest].concat();
            let found = self.resolve(at, &path, depth + 1);
            if !found.is_empty() {
                return found;
            }
        }
        // Made by a macro, or the module alone, which names nothing in it.
        if anchored && !self.modules.contains_key(&child) {
            return module.files.clone();
        }
        none
    }

    /// The files that each file imports from.
    pub(crate) fn imports(&self) -> BTreeMap<usize, BTreeSet<usize>> {
        let mut imports: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for (at, module) in &self.modules {
            for (file, path) in &module.uses {
                let files = self.resolve(at, path, 0);
                // Nor from the file that stands for it on another system.
                let others = files
                    .into_iter()
                    .filter(|other| !module.files.contains(other));
                imports.entry(*file).or_default().extend(others);
            }
        }
        imports
    }

    /// The rooms, modules at the top, that the paths of each file go through, wherever what they name is defined: a room that only hands
    /// a name on is used too.
    pub(crate) fn rooms_named(&self) -> BTreeMap<usize, BTreeSet<String>> {
        let mut named: BTreeMap<usize, BTreeSet<String>> = BTreeMap::new();
        for (at, module) in &self.modules {
            for (file, path) in &module.uses {
                let brought_in = module.names.get(&path[0]).into_iter().flatten();
                let brought_in = brought_in.filter(|full| full.first() != path.first());
                let whole = brought_in.map(|full| [full, &path[1..]].concat());
                // A word alone may be a variable.
                let itself = Some(path.clone()).filter(|path| path.len() > 1);
                let rooms = whole.chain(itself).filter_map(|path| room(at, &path));
                let rooms = rooms.flat_map(|room| self.handed_on(room));
                named.entry(*file).or_default().extend(rooms);
            }
        }
        named
    }

    /// A room, or those from which the root hands on what it calls so.
    fn handed_on(&self, name: String) -> Vec<String> {
        let is_room = |name: &String| self.modules.contains_key(std::slice::from_ref(name));
        if is_room(&name) {
            return vec![name];
        }
        let handed_on = self.modules[&[][..]].names.get(&name);
        let rooms = handed_on.into_iter().flatten();
        let rooms = rooms.filter_map(|path| room(&[], path));
        rooms.filter(is_room).collect()
    }

    /// Paths as they would stand without any `use`.
    fn collect_paths(&mut self) {
        for module in self.modules.values() {
            for (file, path) in &module.uses {
                let paths = &mut self.files[*file].paths;
                paths.insert(path.join("::"));
                for full in module.names.get(&path[0]).into_iter().flatten() {
                    paths.insert([full, &path[1..]].concat().join("::"));
                }
            }
        }
    }
}

/// The room that a path goes into, seen from a module.
fn room(module: &[String], path: &[String]) -> Option<String> {
    let ups = path.iter().take_while(|word| *word == "super").count();
    let (at, rest) = match path.first()?.as_str() {
        "crate" => (&[][..], &path[1..]),
        "self" => (module, &path[1..]),
        "super" => (&module[..module.len().checked_sub(ups)?], &path[ups..]),
        _ => (module, path),
    };
    at.first().or(rest.first()).cloned()
}

/// Reads a crate from the folder that holds its `lib.rs` or `main.rs`.
pub(crate) fn read(folder: &Path) -> Vec<Source> {
    let roots = ["lib.rs", "main.rs"].map(|name| folder.join(name));
    let roots = roots.into_iter().filter(|root| root.exists());
    roots
        .map(|root| {
            let mut source = Source::default();
            read_file(&mut source, &root, folder, &[]);
            source.collect_paths();
            source
        })
        .collect()
}

fn read_file(source: &mut Source, file: &Path, children: &Path, module: &[String]) {
    let text =
        std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let parsed =
        syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let number = source.files.len();
    let mut name = match module {
        [] => "crate".to_owned(),
        module => module.join("::"),
    };
    if source.files.iter().any(|file| file.name == name) {
        let stem = file.file_stem().expect("a file").to_string_lossy();
        name = format!("{name} ({stem})");
    }
    source.files.push(File {
        name,
        ..File::default()
    });
    let entry = source.modules.entry(module.to_vec()).or_default();
    entry.files.insert(number);
    let mut reader = Reader {
        source,
        file: number,
        module: module.to_vec(),
        folder: children.to_owned(),
        base: file.parent().expect("a folder").to_owned(),
    };
    reader.visit_file(&parsed);
}

/// Takes a file apart.
struct Reader<'a> {
    source: &'a mut Source,
    file: usize,
    module: Vec<String>,
    /// Where the files of the modules declared here are.
    folder: PathBuf,
    /// Where a `#[path]` starts from.
    base: PathBuf,
}

impl Reader<'_> {
    fn of_file(&mut self) -> &mut File {
        &mut self.source.files[self.file]
    }

    fn here(&mut self) -> &mut Module {
        self.source.modules.entry(self.module.clone()).or_default()
    }

    fn define(&mut self, name: &syn::Ident) {
        let file = self.file;
        let items = &mut self.here().items;
        items.entry(name.to_string()).or_default().insert(file);
    }

    fn uses(&mut self, path: Vec<String>) {
        let file = self.file;
        if !path.is_empty() {
            self.here().uses.push((file, path));
        }
    }

    fn import(&mut self, before: &[String], tree: &syn::UseTree, for_itself: bool) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.import(&with(&path.ident), &path.tree, for_itself),
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    self.import(before, tree, for_itself);
                }
            }
            syn::UseTree::Glob(_) => {
                self.here().globs.push(before.to_vec());
                if for_itself {
                    self.uses([before, &["*".to_owned()]].concat());
                }
            }
            syn::UseTree::Name(name) if name.ident == "self" => {
                let last = before.last().expect("a module before self").clone();
                self.bind(last, before.to_vec(), for_itself);
            }
            syn::UseTree::Name(name) => {
                self.bind(name.ident.to_string(), with(&name.ident), for_itself);
            }
            syn::UseTree::Rename(name) => {
                self.bind(name.rename.to_string(), with(&name.ident), for_itself);
            }
        }
    }

    fn bind(&mut self, name: String, path: Vec<String>, for_itself: bool) {
        if for_itself {
            self.uses(path.clone());
        }
        self.here().names.entry(name).or_default().push(path);
    }

    /// Paths and texts in what a macro is given, which is not parsed.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.uses(std::mem::take(&mut path));
                    }
                    path.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
                other => {
                    let called = matches!(&other, TokenTree::Punct(mark) if mark.as_char() == '!');
                    if let Some(name) = path.last().filter(|_| called) {
                        self.of_file().macros.insert(name.clone());
                    }
                    self.uses(std::mem::take(&mut path));
                    colons = 0;
                    match other {
                        TokenTree::Group(group) => self.tokens(group.stream()),
                        TokenTree::Literal(literal) => {
                            self.of_file().texts.push(literal.to_string());
                        }
                        _ => {}
                    }
                }
            }
        }
        self.uses(path);
    }
}

/// Whether an item is built for tests only.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) if list.path.is_ident("cfg") => {
            let condition = list.tokens.to_string();
            condition == "test" || condition.starts_with("all (test")
        }
        meta => meta.path().is_ident("test"),
    })
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        syn::Item::Struct(item) => &item.attrs,
        _ => &[],
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if is_test(attributes(item)) {
            return;
        }
        if let Some(name) = name_of(item) {
            self.define(name);
        }
        visit::visit_item(self, item);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        let name = item.ident.to_string();
        let module = [&self.module[..], std::slice::from_ref(&name)].concat();
        if let Some((_, items)) = &item.content {
            let entry = self.source.modules.entry(module.clone()).or_default();
            entry.files.insert(self.file);
            let mut reader = Reader {
                source: self.source,
                file: self.file,
                module,
                folder: self.folder.join(&name),
                base: self.base.clone(),
            };
            items.iter().for_each(|item| reader.visit_item(item));
            return;
        }
        let elsewhere = item
            .attrs
            .iter()
            .find_map(|attribute| match &attribute.meta {
                syn::Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
                    syn::Expr::Lit(syn::ExprLit {
                        lit: syn::Lit::Str(text),
                        ..
                    }) => Some(self.base.join(text.value())),
                    _ => None,
                },
                _ => None,
            });
        let (flat, nested) = (
            self.folder.join(format!("{name}.rs")),
            self.folder.join(&name).join("mod.rs"),
        );
        let file = elsewhere.unwrap_or(if flat.exists() { flat } else { nested });
        let children = self.folder.join(&name);
        read_file(self.source, &file, &children, &module);
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let for_itself = matches!(item.vis, syn::Visibility::Inherited);
        self.import(&[], &item.tree, for_itself);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.uses(words(path));
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        let words = words(&called.path);
        let name = words.last().expect("a name").clone();
        self.of_file().macros.insert(name);
        self.uses(words);
        self.tokens(called.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        // Documentation is none of the program; what clap or serde are told is.
        if !attribute.path().is_ident("doc")
            && let syn::Meta::List(list) = &attribute.meta
        {
            self.uses(words(attribute.path()));
            self.tokens(list.tokens.clone());
        }
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if call.args.is_empty() {
            let name = call.method.to_string();
            self.of_file().asked.insert(name);
        }
        const APART: [&str; 12] = [
            "replace",
            "replacen",
            "contains",
            "starts_with",
            "ends_with",
            "find",
            "split",
            "split_once",
            "strip_prefix",
            "strip_suffix",
            "trim_start_matches",
            "trim_end_matches",
        ];
        let method = call.method.to_string();
        let finished = match &*call.receiver {
            syn::Expr::MethodCall(found) => found.method == "to_string",
            syn::Expr::Macro(found) => found.mac.path.is_ident("format"),
            _ => false,
        };
        if finished && APART.contains(&method.as_str()) {
            self.of_file().edits.push(method);
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_vis_restricted(&mut self, _: &'ast syn::VisRestricted) {}

    fn visit_lit_str(&mut self, text: &'ast syn::LitStr) {
        self.of_file().texts.push(text.value());
    }

    fn visit_item_macro(&mut self, item: &'ast syn::ItemMacro) {
        if let Some(name) = &item.ident {
            self.define(name);
            self.tokens(item.mac.tokens.clone());
            return;
        }
        visit::visit_item_macro(self, item);
    }
}

/// The name that an item defines, but for a macro, whose name may be none, and a module.
const fn name_of(item: &syn::Item) -> Option<&syn::Ident> {
    Some(match item {
        syn::Item::Fn(item) => &item.sig.ident,
        syn::Item::Struct(item) => &item.ident,
        syn::Item::Enum(item) => &item.ident,
        syn::Item::Trait(item) => &item.ident,
        syn::Item::Type(item) => &item.ident,
        syn::Item::Const(item) => &item.ident,
        syn::Item::Static(item) => &item.ident,
        _ => return None,
    })
}

/// The words of a path.
fn words(path: &syn::Path) -> Vec<String> {
    let words = path.segments.iter();
    words.map(|segment| segment.ident.to_string()).collect()
}
