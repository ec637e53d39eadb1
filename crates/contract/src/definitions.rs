//! The definitions of types: indented blocks of `Name  field: type (note), ...`.
//!
//! In the blocks whose enums have a variant a line, sentences stand behind the variants; they are brought into the form
//! of the other blocks first, `variant (note),`, so that there is one grammar.

use crate::types::Content;
use crate::{Definition, Field, Shape, Type, Unreadable, Variant};

/// Lines indented further than this only continue a sentence.
const SENTENCE_COLUMN: usize = 60;

pub(crate) fn definitions(page: &str) -> Result<Vec<Definition>, Unreadable> {
    let section = page
        .split_once("\n## Messages\n")
        .and_then(|(_, rest)| rest.split("\n## ").next())
        .ok_or_else(|| Unreadable("no section Messages".into()))?;
    let lines = section.lines().filter(|line| line.starts_with("    "));
    let mut blocks: Vec<Vec<&str>> = Vec::new();
    for line in lines {
        match blocks.last_mut() {
            Some(block) if line.starts_with("     ") => block.push(line),
            _ => blocks.push(vec![line]),
        }
    }
    blocks.iter().map(|block| definition(block)).collect()
}

fn definition(block: &[&str]) -> Result<Definition, Unreadable> {
    let head = block[0].trim_start();
    let (name, rest) = head.split_once(' ').unwrap_or((head, ""));
    let first = rest.trim_start();
    let text = if first.starts_with("enum {") && (first == "enum {" || first.contains("{  ")) {
        one_variant_a_line(first, &block[1..])
    } else {
        let lines = std::iter::once(first).chain(block[1..].iter().map(|line| line.trim()));
        lines.collect::<Vec<_>>().join(" ")
    };
    let mut parser = Parser { rest: &text };
    let shape = parser
        .definition_body()
        .map_err(|cause| Unreadable(format!("{name}: {cause}, before {:?}", parser.upcoming())))?;
    Ok(Definition {
        name: name.to_owned(),
        shape,
        note: parser.rest.trim().to_owned(),
    })
}

/// `enum { variant { ... } (sentence), ... }` from lines of a variant and a sentence.
fn one_variant_a_line(first: &str, lines: &[&str]) -> String {
    let mut variants: Vec<(String, String)> = Vec::new();
    for line in lines {
        let text = line.trim();
        let continues = line.len() - line.trim_start().len() > SENTENCE_COLUMN;
        match variants.last_mut() {
            Some((_, note)) if continues => {
                note.push(' ');
                note.push_str(text);
            }
            _ => {
                let (code, note) = text.split_once("  ").unwrap_or((text, ""));
                variants.push((code.to_owned(), note.trim().to_owned()));
            }
        }
    }
    let mut text = "enum { ".to_owned();
    let count = variants.len();
    for (index, (code, note)) in variants.into_iter().enumerate() {
        // The last one ends with the brace of the enum.
        let is_last = index + 1 == count;
        let code = if is_last {
            code.strip_suffix('}').unwrap_or(&code)
        } else {
            &code
        };
        text.push_str(code.trim_end());
        if !note.is_empty() {
            text.push_str(&format!(" ({note})"));
        }
        text.push_str(if is_last { " } " } else { ", " });
    }
    text + first.strip_prefix("enum {").unwrap_or_default().trim()
}

struct Parser<'a> {
    rest: &'a str,
}

type Parsed<T> = Result<T, String>;

impl Parser<'_> {
    fn definition_body(&mut self) -> Parsed<Shape> {
        if self.takes_word("enum") {
            return Ok(Shape::Enum(self.braced(Self::variant)?));
        }
        if self.sees("{") {
            return Ok(Shape::Struct(self.fields()?));
        }
        if self
            .rest
            .starts_with(|letter: char| letter.is_ascii_uppercase())
        {
            let mut alternatives = vec![self.name()?];
            while self.takes_word("or") {
                alternatives.push(self.name()?);
            }
            return Ok(Shape::OneOf(alternatives));
        }
        self.field_list().map(Shape::Struct)
    }

    /// `a: T, b, c: U`, where several names share a type.
    fn field_list(&mut self) -> Parsed<Vec<Field>> {
        let mut fields = Vec::new();
        loop {
            let mut names = vec![(self.name()?, self.takes("?"), self.note())];
            while self.takes(",") {
                names.push((self.name()?, self.takes("?"), self.note()));
            }
            self.expect(":")?;
            let ty = self.ty()?;
            let last = self.note();
            for (name, may_be_missing, own) in names {
                let note = if own.is_empty() { last.clone() } else { own };
                let ty = ty.clone().limited(&note);
                fields.push(Field {
                    name,
                    ty,
                    may_be_missing,
                    note,
                });
            }
            if !self.takes(",") {
                return Ok(fields);
            }
        }
    }

    fn fields(&mut self) -> Parsed<Vec<Field>> {
        self.expect("{")?;
        let fields = self.field_list()?;
        self.expect("}")?;
        Ok(fields)
    }

    fn braced<T>(&mut self, item: fn(&mut Self) -> Parsed<T>) -> Parsed<Vec<T>> {
        self.expect("{")?;
        let mut items = vec![item(self)?];
        while self.takes(",") {
            items.push(item(self)?);
        }
        self.expect("}")?;
        Ok(items)
    }

    fn variant(&mut self) -> Parsed<Variant> {
        let name = self.name()?;
        let content = if self.rest.starts_with('(') {
            self.expect("(")?;
            let ty = self.ty()?;
            self.expect(")")?;
            Content::Value(ty)
        } else if self.sees("{") {
            Content::Fields(self.fields()?)
        } else {
            Content::Unit
        };
        let note = self.note();
        let content = match content {
            Content::Value(ty) => Content::Value(ty.limited(&note)),
            other => other,
        };
        Ok(Variant {
            name,
            content,
            note,
        })
    }

    fn ty(&mut self) -> Parsed<Type> {
        if self.sees("{") {
            return Ok(Type::Nested(Box::new(Shape::Struct(self.fields()?))));
        }
        if self.takes("[") {
            let of = self.ty()?;
            if self.sees(",") {
                return self.rest_of_tuple(of);
            }
            self.expect(";")?;
            let length = self.name()?;
            let length = length
                .parse()
                .map_err(|_| format!("{length:?} is no length"))?;
            self.expect("]")?;
            return Ok(Type::Array(Box::new(of), length));
        }
        let word = self.name()?;
        Ok(match word.as_str() {
            "bool" => Type::Bool,
            "u8" => Type::U8,
            "u16" => Type::U16,
            "u32" => Type::U32,
            "u64" => Type::U64,
            "f32" => Type::F32,
            "f64" => Type::F64,
            "string" => Type::String,
            "bytes" => Type::Bytes(None),
            "optional" => Type::Optional(Box::new(self.ty()?)),
            "enum" => Type::Nested(Box::new(Shape::Enum(self.braced(Self::variant)?))),
            "list" if self.takes_word("of") => Type::List(Box::new(self.ty()?), None),
            _ if word.starts_with(|letter: char| letter.is_ascii_uppercase()) => Type::Named(word),
            _ => return Err(format!("{word:?} is no type")),
        })
    }

    fn rest_of_tuple(&mut self, first: Type) -> Parsed<Type> {
        let mut items = vec![first];
        while self.takes(",") {
            items.push(self.ty()?);
        }
        self.expect("]")?;
        Ok(Type::Tuple(items))
    }

    fn name(&mut self) -> Parsed<String> {
        let rest = self.rest.trim_start();
        let is_part = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-');
        let end = rest.find(|letter| !is_part(letter)).unwrap_or(rest.len());
        if end == 0 {
            return Err("a name is missing".into());
        }
        let name = rest[..end].to_owned();
        self.rest = &rest[end..];
        Ok(name)
    }

    /// What stands in parentheses here; parentheses inside are part of it.
    fn note(&mut self) -> String {
        let rest = self.rest.trim_start();
        let mut depth = 0;
        for (index, letter) in rest.char_indices() {
            match letter {
                '(' => depth += 1,
                ')' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                if index == 0 {
                    break;
                }
                let note = rest[1..index].to_owned();
                self.rest = &rest[index + 1..];
                return note;
            }
        }
        String::new()
    }

    fn sees(&self, symbol: &str) -> bool {
        self.rest.trim_start().starts_with(symbol)
    }

    fn takes(&mut self, symbol: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(symbol);
        if let Some(rest) = rest {
            self.rest = rest;
        }
        rest.is_some()
    }

    fn takes_word(&mut self, word: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(word);
        let rest = rest.filter(|rest| rest.starts_with(' '));
        if let Some(rest) = rest {
            self.rest = rest;
        }
        rest.is_some()
    }

    fn expect(&mut self, symbol: &str) -> Parsed<()> {
        if self.takes(symbol) {
            return Ok(());
        }
        Err(format!("{symbol:?} is missing"))
    }

    fn upcoming(&self) -> String {
        self.rest.trim_start().chars().take(40).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str) -> Definition {
        let page = format!("\n## Messages\n{text}\n## Next\n");
        let mut all = definitions(&page).unwrap();
        assert_eq!(all.len(), 1);
        all.remove(0)
    }

    fn field(name: &str, ty: Type, note: &str) -> Field {
        Field {
            name: name.to_owned(),
            ty,
            may_be_missing: false,
            note: note.to_owned(),
        }
    }

    #[test]
    fn fields_share_types_and_have_notes() {
        let read = one(
            "    Report   host: string, a, b: u64 (ns (of UTC)),\n             tags: list of Tag \
             (at most 256)\n             A sentence.",
        );
        let tags = Type::List(Box::new(Type::Named("Tag".into())), Some(256));
        let expected = vec![
            field("host", Type::String, ""),
            field("a", Type::U64, "ns (of UTC)"),
            field("b", Type::U64, "ns (of UTC)"),
            field("tags", tags, "at most 256"),
        ];
        assert_eq!(read.shape, Shape::Struct(expected));
        assert_eq!(read.note, "A sentence.");
    }

    #[test]
    fn variants_hold_nothing_a_value_or_fields() {
        let read =
            one("    Outcome  enum { free-running, refused(Refusal) (why), lens { f: [f64; 5] } }");
        let Shape::Enum(variants) = read.shape else {
            panic!("{read:?}")
        };
        let array = Type::Array(Box::new(Type::F64), 5);
        assert_eq!(variants[0].name, "free-running");
        assert_eq!(
            variants[1].content,
            Content::Value(Type::Named("Refusal".into()))
        );
        assert_eq!(variants[1].note, "why");
        assert_eq!(
            variants[2].content,
            Content::Fields(vec![field("f", array, "")])
        );
    }

    #[test]
    fn sentences_behind_variants_are_their_notes() {
        let sentence = " ".repeat(70) + "or check (again)";
        let read = one(&format!(
            "    Fault    enum {{\n               moved {{ by: f64 }}      it moved: calibrate,\n\
             {sentence}\n               none }}        all is well"
        ));
        let Shape::Enum(variants) = read.shape else {
            panic!("{read:?}")
        };
        assert_eq!(variants[0].note, "it moved: calibrate, or check (again)");
        assert_eq!(
            (variants[1].name.as_str(), variants[1].note.as_str()),
            ("none", "all is well")
        );
    }

    #[test]
    fn json_has_flags_tuples_missing_fields_and_alternatives() {
        let read = one("    state  up: bool, pair?: [string, u64] (joined)");
        let pair = Type::Tuple(vec![Type::String, Type::U64]);
        let pair = Field {
            may_be_missing: true,
            ..field("pair", pair, "joined")
        };
        let expected = vec![field("up", Type::Bool, ""), pair];
        assert_eq!(read.shape, Shape::Struct(expected));
        let zones = Shape::OneOf(vec!["Box".into(), "Sphere".into()]);
        assert_eq!(one("    Zone  Box or Sphere").shape, zones);
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        let page = "\n## Messages\n    Pose  position: f65\n## Next\n";
        let words = definitions(page).unwrap_err().to_string();
        assert!(words.contains("Pose") && words.contains("f65"), "{words}");
    }
}
