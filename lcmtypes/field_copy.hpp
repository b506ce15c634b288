#pragma once

#include "lcmtypes/stamp.hpp"

namespace marco {

/// A value and its message share one list of fields, a generic lambda
/// `(copy, value, message) { copy(value.a, message.a); ... }`, which is read in both directions.
struct CopyToMessage {
  template <class Value, class Field>
  void operator()(const Value& value, Field& field) const {
    field = value;
  }
};
struct CopyFromMessage {
  template <class Value, class Field>
  void operator()(Value& value, const Field& field) const {
    value = field;
  }
};

/// A message with its utime and the listed fields; all others are 0.
template <class Message, class Value, class Fields>
Message message_of(const Value& value, const Fields& fields) {
  Message message{};
  message.utime = value.utime.us;
  fields(CopyToMessage{}, value, message);
  return message;
}

/// The reverse. @throws std::invalid_argument as stamp_of().
template <class Value, class Message, class Fields>
Value value_of(const Message& message, const Fields& fields) {
  Value value;
  value.utime = stamp_of(message.utime);
  fields(CopyFromMessage{}, value, message);
  return value;
}

}  // namespace marco
