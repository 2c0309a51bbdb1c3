//! The arrows of the house: who imports whom, read from the source. No file is in a circle, and between rooms arrows point
//! down the list. What is compiled for tests alone is left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, UseTree};

/// The place of a module under the crate's root.
type Module = Vec<String>;

/// Imports among the files of a crate.
#[derive(Default)]
struct House {
    /// Files by module; the root has no name.
    files: BTreeMap<Module, PathBuf>,
    arrows: BTreeMap<Module, BTreeSet<Module>>,
}

impl House {
    /// Reads the crate `name` whose root is `src`.
    fn read(name: &str, src: &Path) -> House {
        let mut house = House::default();
        house.enter(src, &vec![]);
        let tests = house.tests();
        house.files.retain(|module, _| !tests.iter().any(|test| module.starts_with(test)));
        for (module, file) in &house.files {
            let mut walk = Walk { name, house: &house, module, arrows: BTreeSet::new() };
            walk.visit_file(&parse(file));
            let arrows = walk.arrows;
            house.arrows.insert(module.clone(), arrows);
        }
        house
    }

    /// Lists the source files of a folder.
    fn enter(&mut self, folder: &Path, module: &Module) {
        for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let stem = entry.file_stem().unwrap().to_str().unwrap().to_string();
            let inner = module.iter().cloned().chain([stem.clone()]).collect();
            if entry.is_dir() && stem != "examples" && !entry.join("Cargo.toml").exists() {
                self.enter(&entry, &inner);
            } else if entry.extension().is_some_and(|e| e == "rs") {
                let is_folder = ["mod", "lib"].contains(&stem.as_str());
                self.files.insert(if is_folder { module.clone() } else { inner }, entry);
            }
        }
    }

    /// Modules that are declared for tests.
    fn tests(&self) -> Vec<Module> {
        let declared = |(module, file): (&Module, &PathBuf)| {
            let module = module.clone();
            let test = |item: Item| match item {
                Item::Mod(item) if for_tests(&item.attrs) => Some(item.ident.to_string()),
                _ => None,
            };
            let names = parse(file).items.into_iter().filter_map(test);
            names.map(move |name| module.iter().cloned().chain([name]).collect())
        };
        self.files.iter().flat_map(declared).collect()
    }

    /// Some circle, if there is one.
    fn circle(&self) -> Option<Vec<&Module>> {
        let mut done = BTreeSet::new();
        self.files.keys().find_map(|module| self.circle_from(module, &mut vec![], &mut done))
    }

    fn circle_from<'a>(
        &'a self,
        module: &'a Module,
        way: &mut Vec<&'a Module>,
        done: &mut BTreeSet<&'a Module>,
    ) -> Option<Vec<&'a Module>> {
        if let Some(first) = way.iter().position(|before| *before == module) {
            return Some(way[first..].to_vec());
        }
        if !done.contains(module) {
            way.push(module);
            let found = self.arrows[module].iter().find_map(|next| self.circle_from(next, way, done));
            if found.is_some() {
                return found;
            }
            way.pop();
            done.insert(module);
        }
        None
    }

    /// Arrows that point up the list of `rooms`, or past it.
    fn upward(&self, rooms: &[&str]) -> Vec<String> {
        let floor = |module: &Module| rooms.iter().position(|room| module.first().is_some_and(|m| m == room));
        let arrows = self.arrows.iter().flat_map(|(from, to)| to.iter().map(move |to| (from, to)));
        let up = arrows.filter(|(from, to)| match (floor(from), floor(to)) {
            (Some(from), Some(to)) => from > to,
            (Some(_), None) => true,
            (None, _) => false,
        });
        up.map(|(from, to)| format!("{} → {}", from.join("::"), to.join("::"))).collect()
    }
}

fn parse(file: &Path) -> syn::File {
    syn::parse_file(&fs::read_to_string(file).unwrap()).unwrap()
}

fn for_tests(attributes: &[Attribute]) -> bool {
    let is_test = |a: &Attribute| {
        a.path().is_ident("cfg")
            && a.parse_args::<syn::Path>().is_ok_and(|argument| argument.is_ident("test"))
    };
    attributes.iter().any(is_test)
}

/// Looks for imports in a file.
struct Walk<'a> {
    name: &'a str,
    house: &'a House,
    module: &'a Module,
    arrows: BTreeSet<Module>,
}

impl Walk<'_> {
    /// Notes the file that a path leads to, if it is one of the crate's.
    fn note(&mut self, path: &[String]) {
        let known = |module: &Module| self.house.files.contains_key(module);
        let child = |name: &String| self.module.iter().cloned().chain([name.clone()]).collect::<Module>();
        let mut at = match path.first() {
            Some(first) if first == "crate" || first == self.name => vec![],
            Some(first) if first == "self" || first == "super" => self.module.clone(),
            Some(first) if known(&child(first)) => child(first),
            _ => return,
        };
        for name in path.iter().skip(usize::from(path[0] != "super")) {
            let inner = at.iter().cloned().chain([name.clone()]).collect();
            if name == "super" {
                at.pop();
            } else if known(&inner) {
                at = inner;
            } else {
                break;
            }
        }
        if at != *self.module && known(&at) {
            self.arrows.insert(at);
        }
    }

    fn note_tree(&mut self, tree: &UseTree, before: &[String]) {
        let longer = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            UseTree::Path(path) => self.note_tree(&path.tree, &longer(&path.ident)),
            UseTree::Name(name) => self.note(&longer(&name.ident)),
            UseTree::Rename(name) => self.note(&longer(&name.ident)),
            UseTree::Glob(_) => self.note(before),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.note_tree(tree, before)),
        }
    }
}

impl Visit<'_> for Walk<'_> {
    fn visit_item_mod(&mut self, item: &ItemMod) {
        if !for_tests(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &ItemUse) {
        if !for_tests(&item.attrs) {
            self.note_tree(&item.tree, &[]);
        }
    }

    fn visit_path(&mut self, path: &syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if names.len() > 1 {
            self.note(&names);
        }
        visit::visit_path(self, path);
    }
}

fn check(name: &str, src: &str, rooms: &[&str]) {
    let house = House::read(name, &Path::new(env!("CARGO_MANIFEST_DIR")).join(src));
    for room in rooms {
        assert!(house.files.keys().any(|m| m.first().is_some_and(|m| m == room)), "no {room} in {src}");
    }
    let upward = house.upward(rooms);
    assert!(upward.is_empty(), "arrows that point up in {src}: {upward:#?}");
    let circle = house.circle().map(|circle| circle.iter().map(|m| m.join("::")).collect::<Vec<_>>());
    assert_eq!(circle, None, "a circle of imports in {src}");
}

#[test]
fn arrows_in_the_core_point_down() {
    check("pmcip_core", "src/core", &["tracer", "sampler", "predict", "maths"]);
}

#[test]
fn arrows_in_the_shell_point_down() {
    check(
        "pmcip",
        "src/shell",
        &["command", "compare", "animation", "bake", "film", "frame", "picture", "scene", "error", "machine"],
    );
}

/// What CONTRIBUTING.md says of where things are.
#[test]
fn everything_is_where_the_contributors_page_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("CONTRIBUTING.md")).unwrap();
    let mut found = 0;
    for row in page.lines().filter(|line| line.starts_with("| w")) {
        let cells: Vec<&str> = row.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
        let text = fs::read_to_string(root.join(cells[2])).unwrap_or_else(|e| panic!("{}: {e}", cells[2]));
        assert!(text.contains(cells[3]), "{} is not in {}", cells[3], cells[2]);
        found += 1;
    }
    assert!(found >= 6, "the page answers {found} questions");
}

/// The check itself: a circle and an upward arrow are found.
#[test]
fn circles_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    };
    write("lib.rs", "mod a; mod b; #[cfg(test)] mod tests;");
    write("a/mod.rs", "pub mod inner; pub struct A;");
    write("a/inner.rs", "use crate::b::{C, deep::D};");
    write("b.rs", "fn f() {} #[cfg(test)] mod tests { use crate::a::A; }");
    write("tests.rs", "use crate::b::f;");
    let arrows = |house: &House| house.upward(&["a", "b"]).len() + house.circle().map_or(0, |c| 10 * c.len());
    assert_eq!(arrows(&House::read("x", folder.path())), 0);
    write("b.rs", "fn f() { crate::a::inner::g() }");
    assert_eq!(arrows(&House::read("x", folder.path())), 21);
    write("b.rs", "fn f() {}");
    write("a/inner.rs", "use super::A;");
    assert_eq!(arrows(&House::read("x", folder.path())), 0);
    write("a/mod.rs", "pub mod inner; pub use inner::B; pub struct A;");
    assert_eq!(arrows(&House::read("x", folder.path())), 20);
}
