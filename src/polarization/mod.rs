//! Floor 1: the algebra of polarized light. No rendering here.
