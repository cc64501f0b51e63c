//! The values of a sweep by the names of its axes, in the order in which the job file has these: a
//! table of JSON has its keys by the alphabet.

use std::fmt;

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

/// What the axes of a sweep are for a job.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values(Vec<(String, Value)>);

impl Values {
    /// Adds an axis, or gives it another value.
    pub fn insert(&mut self, name: String, value: Value) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = value,
            None => self.0.push((name, value)),
        }
    }

    /// The value of an axis.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.iter().find(|(known, _)| *known == name).map(|(_, value)| value)
    }

    /// Names and values.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// Whether it is of no sweep.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(InOrder)
    }
}

/// Reads a table in its order.
struct InOrder;

impl<'de> Visitor<'de> for InOrder {
    type Value = Values;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a table of values")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Values, A::Error> {
        let mut values = Values::default();
        while let Some((name, value)) = table.next_entry()? {
            values.insert(name, value);
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_keep_their_order() {
        let text = r#"{"z":1,"a":[2.5],"m":"x"}"#;
        let mut values: Values = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&values).unwrap(), text);
        values.insert("a".to_owned(), Value::from(3));
        values.insert("b".to_owned(), Value::Null);
        let text = r#"{"z":1,"a":3,"m":"x","b":null}"#;
        assert_eq!(serde_json::to_string(&values).unwrap(), text);
        assert_eq!((values.get("a"), values.get("c")), (Some(&Value::from(3)), None));
        assert!(serde_json::from_str::<Values>("[1]").is_err());
    }
}
