//! A crate's source as a test of its structure needs it: which file defines which name, and which names a file uses.
//!
//! Rules:
//! - A module is its file; an inline `mod` belongs to the file it stands in.
//! - `pub use` hands a name on and is no import; a name so handed on stands for the file that defines it.
//! - What is built for tests only does not count, nor do comments and documentation.

use std::collections::{BTreeMap, BTreeSet};

/// What the sources of a crate say about each of its files, by the file's module: `a::b`, or `crate` for the root.
#[derive(Debug, Default)]
pub(crate) struct Source {
    /// The files of a module path: two where the system decides which is built.
    pub(crate) modules: BTreeMap<Vec<String>, Module>,
    /// Name of each file.
    pub(crate) files: Vec<File>,
}

/// A file.
#[derive(Debug)]
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
}

#[derive(Debug, Default)]
pub(crate) struct Module {
    pub(crate) files: BTreeSet<usize>,
    /// Where a name is defined here, by number of the file.
    pub(crate) items: BTreeMap<String, BTreeSet<usize>>,
    /// Names that `use` brings in: the full path as written.
    pub(crate) names: BTreeMap<String, Vec<Vec<String>>>,
    /// Modules of which all names are brought in.
    pub(crate) globs: Vec<Vec<String>>,
    /// Paths in code and in imports for oneself, each with the file it stands in.
    pub(crate) uses: Vec<(usize, Vec<String>)>,
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
        for glob in &module.globs {
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

    /// Paths as they would stand without any `use`.
    pub(crate) fn collect_paths(&mut self) {
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
