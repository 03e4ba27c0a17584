//! From tokens to arrays.

use std::iter::Peekable;

use coaxle_node::config::Wrong;

use super::arrays::{Array, Arrays, Element, Kind};
use super::token::{Token, Tokens};
use crate::point_table::field::{Field, Value, default_point};

pub(super) struct Parser<'a> {
    tokens: Peekable<Tokens<'a>>,
    /// Line of the last token taken.
    line: usize,
}

impl<'a> Parser<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self {
            tokens: Tokens::new(text).peekable(),
            line: 1,
        }
    }

    /// Reads all arrays that can hold a plate; errors in arrays other than the wanted one are ignored.
    pub(super) fn arrays(mut self, wanted: Option<&str>) -> Result<Arrays<'a>, Wrong> {
        let mut arrays = Arrays::default();
        while let Some(token) = self.next() {
            let Token::Word(name) = token else { continue };
            // A program has many arrays, and only the wanted one has to be a plate.
            let is_wanted = wanted.is_none_or(|wanted| wanted.eq_ignore_ascii_case(name));
            // `:` and not `:=`, which is a token of its own.
            let read = if self.take_sign(':') {
                self.declaration(name, &mut arrays)
            } else if self.take_sign('[') {
                self.assignment(name, &mut arrays)
            } else {
                Ok(())
            };
            read.or_else(|wrong| if is_wanted { Err(wrong) } else { Ok(()) })?;
        }
        Ok(arrays)
    }

    /// Reads `ARRAY[1..3] OF MC_MotionFunctionPoint := [ … ]`; the name and `:` are already taken.
    fn declaration(&mut self, name: &'a str, arrays: &mut Arrays<'a>) -> Result<(), Wrong> {
        // Other declarations are skipped up to the next word that has a colon or a bracket.
        if !self.take_word("ARRAY") || !self.take_sign('[') {
            return Ok(());
        }
        let mut dimensions = Vec::new();
        loop {
            dimensions.push(self.bounds());
            if !self.take_sign(',') {
                break;
            }
        }
        if !self.take_sign(']') || !self.take_word("OF") {
            return Ok(());
        }
        // Points have one dimension. Positions have two, of rows and columns.
        let kind = match (self.next(), dimensions.len()) {
            (Some(Token::Word(of)), 1) if of.eq_ignore_ascii_case("MC_MotionFunctionPoint") => {
                Kind::Points
            }
            (Some(Token::Word(of)), 2) if is_number_type(of) => Kind::Positions,
            _ => return Ok(()),
        };
        // A bound that is a constant of the program is unknown: elements are counted from 0 then.
        let first = |n: usize| dimensions.get(n).copied().flatten().unwrap_or_default();
        let array = arrays.declared(name, kind, [first(0), first(1)], self.line);
        if !self.take_sign('=') {
            return Ok(());
        }
        self.expect('[')?;
        let read = match kind {
            Kind::Points => Self::point,
            Kind::Positions => Self::position,
        };
        self.list(array, read, true)
    }

    /// Reads the first index of a dimension, `1` of `1..3`; none where it is not a literal.
    fn bounds(&mut self) -> Option<i64> {
        let first = self.whole_literal();
        // `1..3`: without the two points the literal is part of an expression.
        let is_literal = self.take_sign('~');
        // The last index does not matter: elements without an initial value are not part of the plate.
        // To the end of the dimension: expressions are skipped.
        while !matches!(self.peek(), None | Some(Token::Sign(',' | ']' | ';'))) {
            self.next();
        }
        first.filter(|_| is_literal)
    }

    /// Reads the elements of an initial value after its `[`, each possibly repeated: `3(0.0)`.
    fn list(
        &mut self,
        array: &mut Array,
        read: fn(&mut Self) -> Result<Element, Wrong>,
        may_nest: bool,
    ) -> Result<(), Wrong> {
        while !self.take_sign(']') {
            // Some programs write a list for each row.
            // A single level: rows of an array of two dimensions.
            if may_nest && self.take_sign('[') {
                self.list(array, read, false)?;
            } else {
                let element = read(self)?;
                // A number before a bracket is a count, as in `3(0.0)`.
                let (times, element) = match (element, self.peek()) {
                    (Element::Number(times), Some(Token::Sign('('))) => {
                        self.expect('(')?;
                        let element = read(self)?;
                        self.expect(')')?;
                        (times, element)
                    }
                    (element, _) => (1.0, element),
                };
                let pushed = array.push(times, element);
                pushed.map_err(|wrong| self.in_line(wrong))?;
            }
            // At the end of the file neither comes, so that the loop ends with an error.
            if !self.take_sign(',') && self.peek() != Some(Token::Sign(']')) {
                return Err(self.unexpected("',' or ']'"));
            }
        }
        Ok(())
    }

    fn position(&mut self) -> Result<Element, Wrong> {
        let number = self.value()?.number();
        number
            .map(Element::Number)
            .map_err(|wrong| self.in_line(wrong))
    }

    /// `(PointIndex := 1, …)`.
    fn point(&mut self) -> Result<Element, Wrong> {
        let mut point = default_point();
        self.expect('(')?;
        while !self.take_sign(')') {
            let field = self.field()?;
            self.expect('=')?;
            let value = self.value()?;
            let set = field.set(&mut point, value);
            set.map_err(|wrong| self.in_line(wrong.within(field.plc_name())))?;
            if !self.take_sign(',') && self.peek() != Some(Token::Sign(')')) {
                return Err(self.unexpected("',' or ')'"));
            }
        }
        Ok(Element::Point(Box::new(point)))
    }

    /// Reads `[1].MasterPos := 0.0` or `[0, 1] := 0.0`; the name and `[` are already taken. Others
    /// are skipped.
    fn assignment(&mut self, name: &'a str, arrays: &mut Arrays<'a>) -> Result<(), Wrong> {
        // An index that is a variable belongs to a loop, whose values are not in the text.
        let Some(row) = self.whole_literal() else {
            return Ok(());
        };
        if self.take_sign(',') {
            let column = self.whole_literal();
            let (Some(column), true, true) = (column, self.take_sign(']'), self.take_sign('='))
            else {
                return Ok(());
            };
            let value = self.value()?;
            let number = value.number().map_err(|wrong| self.in_line(wrong))?;
            let array = arrays.assigned(name, Kind::Positions, self.line);
            return array
                .assign_position(row, column, number)
                .map_err(|wrong| self.in_line(wrong));
        }
        // Other structures have fields with other names.
        if !(self.take_sign(']') && self.take_sign('.')) {
            return Ok(());
        }
        let Some(Token::Word(word)) = self.next() else {
            return Ok(());
        };
        let (Some(field), true) = (Field::called(word), self.take_sign('=')) else {
            return Ok(());
        };
        let value = self.value()?;
        let array = arrays.assigned(name, Kind::Points, self.line);
        array
            .assign_field(row, field, value)
            .map_err(|wrong| self.in_line(wrong.within(field.plc_name())))
    }

    fn field(&mut self) -> Result<Field, Wrong> {
        match self.next() {
            Some(Token::Word(word)) => Field::called(word).ok_or_else(|| {
                let expected = format!("some of {}", Field::ALL.map(Field::plc_name).join(", "));
                self.in_line(Wrong::value(format_args!("field {word:?}"), expected))
            }),
            _ => Err(self.in_line(Wrong::value("no field", "one of MC_MotionFunctionPoint"))),
        }
    }

    /// Reads a number with its sign, `LREAL#1.5`, or a word, possibly after the name of its type:
    /// `MC_MotionPointType.MOTIONPOINTTYPE_REST`.
    fn value(&mut self) -> Result<Value<'a>, Wrong> {
        let sign = if self.take_sign('-') { -1.0 } else { 1.0 };
        // A plus says nothing.
        self.take_sign('+');
        match self.next() {
            Some(Token::Number(number)) => Ok(Value::Number(sign * number)),
            Some(Token::Word(mut word)) => {
                while self.take_sign('.') || self.take_sign('#') {
                    // `LREAL#-1.5`: the sign may stand behind the type.
                    let sign = if self.take_sign('-') { -1.0 } else { sign };
                    match self.next() {
                        Some(Token::Number(number)) => return Ok(Value::Number(sign * number)),
                        Some(Token::Word(next)) => word = next,
                        _ => return Err(self.unexpected("a value")),
                    }
                }
                Ok(Value::Word(word))
            }
            Some(Token::Garbled(text)) => {
                Err(self.in_line(Wrong::value(format_args!("{text:?}"), "a number")))
            }
            _ => Err(self.in_line(Wrong::value("no value", "a number or a name"))),
        }
    }

    fn whole_literal(&mut self) -> Option<i64> {
        let is_negative = self.take_sign('-');
        let Some(Token::Number(number)) = self.peek() else {
            return None;
        };
        self.next();
        // Bounded, so that differences of indices cannot overflow.
        let is_whole = number.fract() == 0.0 && number.abs() < 1e9;
        is_whole.then_some(if is_negative { -number } else { number } as i64)
    }

    fn peek(&mut self) -> Option<Token<'a>> {
        self.tokens.peek().map(|(_, token)| *token)
    }

    fn next(&mut self) -> Option<Token<'a>> {
        let (line, token) = self.tokens.next()?;
        // Kept for errors: the token that is wrong has been taken.
        self.line = line;
        Some(token)
    }

    fn take_sign(&mut self, sign: char) -> bool {
        let is_it = self.peek() == Some(Token::Sign(sign));
        if is_it {
            self.next();
        }
        is_it
    }

    fn take_word(&mut self, expected: &str) -> bool {
        let is_it =
            matches!(self.peek(), Some(Token::Word(word)) if word.eq_ignore_ascii_case(expected));
        if is_it {
            self.next();
        }
        is_it
    }

    fn expect(&mut self, sign: char) -> Result<(), Wrong> {
        if self.take_sign(sign) {
            return Ok(());
        }
        Err(self.unexpected(match sign {
            '=' => "':='",
            '[' => "'['",
            ')' => "')'",
            _ => "'('",
        }))
    }

    fn unexpected(&mut self, expected: &str) -> Wrong {
        let received = match self.next() {
            Some(Token::Word(text) | Token::Garbled(text)) => format!("{text:?}"),
            Some(Token::Number(number)) => number.to_string(),
            Some(Token::Sign('=')) => "':='".to_owned(),
            Some(Token::Sign(sign)) => format!("{sign:?}"),
            None => "the end of the file".to_owned(),
        };
        self.in_line(Wrong::value(received, expected))
    }

    /// Adds the line of the last token taken.
    fn in_line(&self, wrong: Wrong) -> Wrong {
        // Behind a colon: the field of a point is no part of the line's place.
        Wrong::with_reason(format!("line {}", self.line), wrong)
    }
}

fn is_number_type(word: &str) -> bool {
    ["LREAL", "REAL"]
        .iter()
        .any(|name| name.eq_ignore_ascii_case(word))
}
