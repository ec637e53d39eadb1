//! Rules about functions, types and documentation, by the syntax tree.

use super::Finding;
use crate::source::{Rust, Source};
use proc_macro2::Span;
use syn::visit::{self, Visit};
use syn::{Attribute, Block, Expr, FnArg, Ident, Lit, Meta, Pat, Signature, Type, Visibility};

/// What fits on a screen.
const FUNCTION_LINES: usize = 60;
/// A test tells its story in one piece.
const TEST_FUNCTION_LINES: usize = 120;
/// Names that many things have.
const GENERIC: &[&str] = &[
    "State",
    "View",
    "Kind",
    "Outcome",
    "Models",
    "Equations",
    "Layout",
    "Site",
];
/// A sentence of documentation has more words.
const FEWEST_WORDS: usize = 3;

/// Findings of a file, and the types of generic names that it defines.
pub fn check(source: &Source, rust: &Rust) -> (Vec<Finding>, Vec<GenericType>) {
    let mut rules = Rules {
        path: &source.path,
        is_test: rust.is_test,
        implements_trait: false,
        findings: Vec::new(),
        generic_types: Vec::new(),
    };
    rules.visit_file(&rust.file);
    (rules.findings, rules.generic_types)
}

/// Where a type with one of the [`GENERIC`] names is defined.
pub struct GenericType {
    name: String,
    path: String,
    line: usize,
}

/// A generic name may be that of one type in all product code, so that it needs no "whose".
pub fn check_generic_types(mut types: Vec<GenericType>) -> Vec<Finding> {
    types.sort_by(|a, b| (&a.name, &a.path, a.line).cmp(&(&b.name, &b.path, b.line)));
    let of_one_name = types.chunk_by(|a, b| a.name == b.name);
    let several = of_one_name.filter(|types| types.len() > 1).flatten();
    let finding = |it: &GenericType| {
        let remedy = format!(
            "there are several types `{0}`: say whose, such as Track{0}",
            it.name
        );
        Finding::new(&it.path, it.line, "type name", remedy)
    };
    several.map(finding).collect()
}

struct Rules<'a> {
    path: &'a str,
    is_test: bool,
    /// Within an `impl Trait for`: the trait decides about signatures and names.
    implements_trait: bool,
    findings: Vec<Finding>,
    generic_types: Vec<GenericType>,
}

impl Rules<'_> {
    fn add(&mut self, span: Span, rule: &'static str, remedy: impl Into<String>) {
        let line = span.start().line;
        self.findings
            .push(Finding::new(self.path, line, rule, remedy));
    }

    fn function(&mut self, signature: &Signature, body: &Block) {
        let end = body.brace_token.span.close().end().line;
        let lines = end + 1 - signature.fn_token.span.start().line;
        let most = match self.is_test {
            true => TEST_FUNCTION_LINES,
            false => FUNCTION_LINES,
        };
        let name = &signature.ident;
        if lines > most {
            let remedy = format!("`{name}` has {lines} lines: split it, {most} are the most");
            self.add(name.span(), "length", remedy);
        }
        if self.implements_trait {
            return;
        }
        if name == "of" {
            let remedy = "name what it makes: new, from_x, between, measure ...";
            self.add(name.span(), "fn of", remedy);
        }
        for parameter in &signature.inputs {
            if let FnArg::Typed(parameter) = parameter
                && (is_tuple(&parameter.ty) || matches!(*parameter.pat, Pat::Tuple(_)))
            {
                let remedy =
                    format!("`{name}` has a tuple as parameter: two parameters, or a type");
                self.add(parameter.colon_token.spans[0], "tuple", remedy);
            }
        }
    }

    fn type_name(&mut self, name: &Ident) {
        if !self.is_test && GENERIC.iter().any(|generic| name == generic) {
            self.generic_types.push(GenericType {
                name: name.to_string(),
                path: self.path.to_owned(),
                line: name.span().start().line,
            });
        }
    }

    fn documentation(&mut self, visibility: &Visibility, name: &Ident, attributes: &[Attribute]) {
        if !matches!(visibility, Visibility::Public(_)) || self.is_test {
            return;
        }
        let text = documentation(attributes);
        let own = text.lines().map(str::trim);
        let own: Vec<&str> = own.filter(|line| !line.starts_with('#')).collect();
        let text = own.join(" ");
        let words: Vec<String> = text.split_whitespace().map(plain).collect();
        if words.is_empty() {
            return;
        }
        let of_name = plain(&name.to_string().replace('_', ""));
        let repeats = words
            .concat()
            .trim_start_matches("the")
            .trim_start_matches('a')
            == of_name;
        if words.len() <= FEWEST_WORDS || repeats {
            let remedy = format!("`{name}`: say more than the name: what, in which unit, why");
            self.add(name.span(), "docs", remedy);
        }
    }
}

fn is_tuple(ty: &Type) -> bool {
    match ty {
        Type::Tuple(tuple) => !tuple.elems.is_empty(),
        Type::Reference(reference) => is_tuple(&reference.elem),
        _ => false,
    }
}

fn documentation(attributes: &[Attribute]) -> String {
    let lines = attributes
        .iter()
        .filter_map(|attribute| match &attribute.meta {
            Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
                Expr::Lit(literal) => match &literal.lit {
                    Lit::Str(text) => Some(text.value()),
                    _ => None,
                },
                _ => None,
            },
            _ => None,
        });
    lines.collect::<Vec<_>>().join("\n")
}

fn plain(word: &str) -> String {
    let letters = word.chars().filter(|c| c.is_alphanumeric());
    letters.collect::<String>().to_lowercase()
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute
                .parse_args::<syn::Path>()
                .is_ok_and(|path| path.is_ident("test"))
    })
}

impl Visit<'_> for Rules<'_> {
    fn visit_item_mod(&mut self, item: &syn::ItemMod) {
        let before = self.is_test;
        self.is_test |= is_for_tests(&item.attrs);
        visit::visit_item_mod(self, item);
        self.is_test = before;
    }

    fn visit_item_fn(&mut self, item: &syn::ItemFn) {
        self.function(&item.sig, &item.block);
        self.documentation(&item.vis, &item.sig.ident, &item.attrs);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &syn::ImplItemFn) {
        self.function(&item.sig, &item.block);
        self.documentation(&item.vis, &item.sig.ident, &item.attrs);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &syn::TraitItemFn) {
        if let Some(body) = &item.default {
            self.function(&item.sig, body);
        }
        visit::visit_trait_item_fn(self, item);
    }

    fn visit_item_impl(&mut self, item: &syn::ItemImpl) {
        let before = self.implements_trait;
        self.implements_trait = item.trait_.is_some();
        visit::visit_item_impl(self, item);
        self.implements_trait = before;
    }

    fn visit_item_struct(&mut self, item: &syn::ItemStruct) {
        self.type_name(&item.ident);
        self.documentation(&item.vis, &item.ident, &item.attrs);
        visit::visit_item_struct(self, item);
    }

    fn visit_item_enum(&mut self, item: &syn::ItemEnum) {
        self.type_name(&item.ident);
        self.documentation(&item.vis, &item.ident, &item.attrs);
        visit::visit_item_enum(self, item);
    }

    fn visit_item_type(&mut self, item: &syn::ItemType) {
        self.type_name(&item.ident);
        self.documentation(&item.vis, &item.ident, &item.attrs);
    }

    fn visit_item_trait(&mut self, item: &syn::ItemTrait) {
        self.type_name(&item.ident);
        self.documentation(&item.vis, &item.ident, &item.attrs);
        visit::visit_item_trait(self, item);
    }

    fn visit_item_const(&mut self, item: &syn::ItemConst) {
        self.documentation(&item.vis, &item.ident, &item.attrs);
        visit::visit_item_const(self, item);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        let source = Source::new("a.rs", text.to_owned()).unwrap();
        let (findings, _) = check(&source, source.rust.as_ref().unwrap());
        findings.iter().map(ToString::to_string).collect()
    }

    fn rules(text: &str) -> Vec<&'static str> {
        let source = Source::new("a.rs", text.to_owned()).unwrap();
        let (findings, _) = check(&source, source.rust.as_ref().unwrap());
        findings.iter().map(|finding| finding.rule).collect()
    }

    #[test]
    fn a_function_of_61_lines_is_too_long_and_a_test_of_61_is_not() {
        let long = format!("fn f() {{\n{}}}\n", "    g();\n".repeat(59));
        let expected = "a.rs:1: length: `f` has 61 lines: split it, 60 are the most";
        assert_eq!(found(&long), [expected]);
        let test = format!("#[cfg(test)]\nmod tests {{\n{long}}}\n");
        assert_eq!(rules(&test), [""; 0]);
    }

    #[test]
    fn tuples_and_of_are_found_but_where_a_trait_asks_for_them() {
        let text = "fn f(a: (u8, u8)) {} impl A { fn of((b, c): &(u8, u8)) {} }
            impl From<(u8, u8)> for A { fn from(pair: (u8, u8)) -> Self { A } }
            fn g(a: [u8; 2], nothing: ()) {}";
        assert_eq!(rules(text), ["tuple", "fn of", "tuple"]);
    }

    #[test]
    fn documentation_of_a_public_item_says_more_than_its_name() {
        let text = "/// The board layout.\npub struct BoardLayout;
            /// Width.\npub fn width() {}
            /// Width of the board, metres.\npub fn width_m() {}
            /// A step.\nstruct Step;";
        assert_eq!(rules(text), ["docs", "docs"]);
    }

    #[test]
    fn generic_type_names_are_reported_where_there_are_two() {
        let types = |text: &str| {
            let source = Source::new("a.rs", text.to_owned()).unwrap();
            check(&source, source.rust.as_ref().unwrap()).1
        };
        assert!(check_generic_types(types("struct State; enum Kind {}")).is_empty());
        let both = check_generic_types(types("struct State; mod m { enum State {} }"));
        assert_eq!(both.len(), 2, "{both:?}");
    }
}
