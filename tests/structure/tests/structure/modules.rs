//! The modules of a crate, and the uses between them, read from the source.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use syn::visit::{self, Visit};
use syn::{Attribute, Item, UseTree};

/// A module's number; 0 is the crate's root.
pub(crate) type ModuleId = usize;

/// A crate as its modules.
#[derive(Default)]
pub(crate) struct Crate {
    modules: Vec<Module>,
}

#[derive(Default)]
struct Module {
    name: String,
    parent: Option<ModuleId>,
    children: BTreeMap<String, ModuleId>,
    /// Names that it defines itself, except by macros.
    items: BTreeSet<String>,
    /// Imports and re-exports, by the name they have here.
    imports: Vec<Import>,
    /// Paths in its code that begin with `crate`, `self` or `super`.
    paths: Vec<Vec<String>>,
}

struct Import {
    path: Vec<String>,
    /// Absent for everything (`*`).
    name: Option<String>,
}

impl Crate {
    /// Reads a crate, tests left out, from its `lib.rs`.
    pub(crate) fn read(library: &Path) -> Self {
        let mut read = Self::default();
        let folder = library.parent().expect("a folder");
        // The root has the number 0 by being read first, which `resolve` relies on.
        read.read_file(library, folder, "crate", None);
        read
    }

    /// Every module.
    pub(crate) fn modules(&self) -> std::ops::Range<ModuleId> {
        0..self.modules.len()
    }

    /// The path of a module.
    pub(crate) fn name(&self, module: ModuleId) -> String {
        let Module { name, parent, .. } = &self.modules[module];
        match parent {
            None => name.clone(),
            Some(parent) => format!("{}::{name}", self.name(*parent)),
        }
    }

    /// The module and all above it, the root last.
    pub(crate) fn lineage(&self, module: ModuleId) -> impl Iterator<Item = ModuleId> {
        std::iter::successors(Some(module), |&module| self.modules[module].parent)
    }

    /// The modules that a module uses.
    pub(crate) fn used_by(&self, module: ModuleId) -> BTreeSet<ModuleId> {
        let this = &self.modules[module];
        let imported = this.imports.iter().map(|import| &import.path);
        imported
            .chain(&this.paths)
            .filter_map(|path| self.resolve(module, path, 0))
            .filter(|&used| used != module)
            .collect()
    }

    fn read_file(&mut self, file: &Path, folder: &Path, name: &str, parent: Option<ModuleId>) {
        let shown = file.display();
        let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{shown}: {error}"));
        let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{shown}: {error}"));
        self.read_items(&syntax.items, folder, name, parent);
    }

    /// Reads items; `folder` is that of files of modules inside this one.
    fn read_items(&mut self, items: &[Item], folder: &Path, name: &str, parent: Option<ModuleId>) {
        let id = self.modules.len();
        self.modules.push(Module {
            name: name.to_owned(),
            parent,
            ..Module::default()
        });
        // Before its content, whose paths may lead through it.
        if let Some(parent) = parent {
            self.modules[parent].children.insert(name.to_owned(), id);
        }
        for item in items.iter().filter(|item| !is_left_out(item)) {
            match item {
                Item::Mod(module) => {
                    let name = module.ident.to_string();
                    let inner = folder.join(&name);
                    match &module.content {
                        Some((_, items)) => self.read_items(items, &inner, &name, Some(id)),
                        None => {
                            let beside = folder.join(format!("{name}.rs"));
                            let within = inner.join("mod.rs");
                            // Both places of a module's file, as the compiler has them.
                            let file = if beside.exists() { beside } else { within };
                            self.read_file(&file, &inner, &name, Some(id));
                        }
                    }
                }
                Item::Use(import) => {
                    let imports = &mut self.modules[id].imports;
                    flatten(&import.tree, &mut Vec::new(), imports);
                }
                item => {
                    self.modules[id].items.extend(name_of(item));
                    let mut paths = Paths(&mut self.modules[id].paths);
                    paths.visit_item(item);
                }
            }
        }
    }

    /// The module that defines the target of a path; none if that is in another crate.
    fn resolve(&self, from: ModuleId, path: &[String], depth: u32) -> Option<ModuleId> {
        let (first, mut rest) = path.split_first()?;
        let mut at = match first.as_str() {
            "crate" => 0,
            "self" => from,
            "super" => self.modules[from].parent?,
            name => {
                let child = self.modules[from].children.get(name)?;
                *child
            }
        };
        while let Some((name, further)) = rest.split_first() {
            let module = &self.modules[at];
            // `super::super` goes up step by step.
            if name == "super" {
                at = module.parent?;
            } else if let Some(&child) = module.children.get(name) {
                at = child;
            } else {
                return Some(self.definition(at, name, depth));
            }
            rest = further;
        }
        Some(at)
    }

    /// Follows re-exports of a name. An unknown name is taken as defined by a macro in that module.
    fn definition(&self, at: ModuleId, name: &str, depth: u32) -> ModuleId {
        let module = &self.modules[at];
        // Bounded, since re-exports may lead in a circle.
        if module.items.contains(name) || depth > 8 {
            return at;
        }
        let is_it = |import: &&Import| import.name.as_deref() == Some(name);
        let named = module.imports.iter().find(is_it);
        named
            .and_then(|import| self.resolve(at, &import.path, depth + 1))
            .unwrap_or(at)
    }
}

/// True for tests, and for items that only the documentation needs.
fn is_left_out(item: &Item) -> bool {
    let attributes = match item {
        Item::Mod(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Const(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        _ => return false,
    };
    attributes.iter().any(is_test_or_doc)
}

fn is_test_or_doc(attribute: &Attribute) -> bool {
    let mut found = false;
    if attribute.path().is_ident("cfg") {
        let _ = attribute.parse_nested_meta(|meta| {
            // Any part of the condition: `all(test, …)` is a test too.
            found |= meta.path.is_ident("test") || meta.path.is_ident("doc");
            Ok(())
        });
    }
    found
}

fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

/// `use a::{b, c as d}` as `a::b` and `a::c`.
fn flatten(tree: &UseTree, path: &mut Vec<String>, imports: &mut Vec<Import>) {
    match tree {
        UseTree::Path(step) => {
            path.push(step.ident.to_string());
            flatten(&step.tree, path, imports);
            path.pop();
        }
        UseTree::Group(group) => {
            for tree in &group.items {
                flatten(tree, path, imports);
            }
        }
        UseTree::Glob(_) => imports.push(Import {
            path: path.clone(),
            name: None,
        }),
        UseTree::Name(last) => import(path, &last.ident, &last.ident, imports),
        UseTree::Rename(last) => import(path, &last.ident, &last.rename, imports),
    }
}

fn import(path: &[String], last: &syn::Ident, name: &syn::Ident, imports: &mut Vec<Import>) {
    let mut path = path.to_vec();
    // `use a::{self}` is `use a`.
    if last != "self" || path.is_empty() {
        path.push(last.to_string());
    }
    let name = if name == "self" {
        path.last().cloned()
    } else {
        Some(name.to_string())
    };
    imports.push(Import { path, name });
}

/// Collects paths in code.
struct Paths<'a>(&'a mut Vec<Vec<String>>);

impl<'ast> Visit<'ast> for Paths<'_> {
    fn visit_path(&mut self, path: &'ast syn::Path) {
        let path_names: Vec<_> = path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        // Other first segments are of other crates, or of an import, which counts itself.
        if matches!(path_names[0].as_str(), "crate" | "self" | "super") && path_names.len() > 1 {
            self.0.push(path_names);
        }
        visit::visit_path(self, path);
    }

    fn visit_item_use(&mut self, inner: &'ast syn::ItemUse) {
        let mut imports = Vec::new();
        flatten(&inner.tree, &mut Vec::new(), &mut imports);
        self.0.extend(imports.into_iter().map(|import| import.path));
    }
}
