"""Un paramètre : un nom, un type, une valeur."""

import array
from enum import Enum

from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterType, ParameterValue

PARAMETER_SEPARATOR_STRING = "."

_CHAMPS = {
    1: ("bool_value", bool),
    2: ("integer_value", int),
    3: ("double_value", float),
    4: ("string_value", str),
    5: ("byte_array_value", bytes),
    6: ("bool_array_value", bool),
    7: ("integer_array_value", int),
    8: ("double_array_value", float),
    9: ("string_array_value", str),
}
#: Un booléen est aussi un entier pour Python : on cherche dans cet ordre.
_SEULS, _SUITES = (1, 2, 3, 4), (5, 6, 7, 8, 9)


class Parameter:
    class Type(Enum):
        NOT_SET = ParameterType.PARAMETER_NOT_SET
        BOOL = ParameterType.PARAMETER_BOOL
        INTEGER = ParameterType.PARAMETER_INTEGER
        DOUBLE = ParameterType.PARAMETER_DOUBLE
        STRING = ParameterType.PARAMETER_STRING
        BYTE_ARRAY = ParameterType.PARAMETER_BYTE_ARRAY
        BOOL_ARRAY = ParameterType.PARAMETER_BOOL_ARRAY
        INTEGER_ARRAY = ParameterType.PARAMETER_INTEGER_ARRAY
        DOUBLE_ARRAY = ParameterType.PARAMETER_DOUBLE_ARRAY
        STRING_ARRAY = ParameterType.PARAMETER_STRING_ARRAY

        @classmethod
        def from_parameter_value(cls, parameter_value):
            """Le type d'une valeur de Python. 1 est un entier, 1.0 un réel : pour ROS, ce n'est pas la même chose."""
            if parameter_value is None:
                return cls.NOT_SET
            for numero in _SEULS:
                if isinstance(parameter_value, _CHAMPS[numero][1]):
                    return cls(numero)
            if isinstance(parameter_value, (list, tuple, array.array)):
                for numero in _SUITES:
                    if all(isinstance(valeur, _CHAMPS[numero][1]) for valeur in parameter_value):
                        return cls(numero)
                raise TypeError(f"The given value is not a list of one of the allowed types '{parameter_value}'.")
            raise TypeError(f"The given value is not one of the allowed types '{parameter_value}'.")

        def check(self, parameter_value):
            """La valeur est-elle de ce type ?"""
            if self is Parameter.Type.NOT_SET:
                return parameter_value is None
            genre = _CHAMPS[self.value][1]
            if self.value in _SEULS:
                return isinstance(parameter_value, genre)
            suite = isinstance(parameter_value, (list, tuple, array.array))
            return suite and all(isinstance(valeur, genre) for valeur in parameter_value)

    def __init__(self, name, type_=None, value=None):
        if type_ is None:
            type_ = Parameter.Type.from_parameter_value(value)
        if not isinstance(type_, Parameter.Type):
            raise TypeError(f"type must be an instance of '{Parameter.Type!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value}' do not agree")
        self._name, self._type_, self._value = name, type_, value

    @property
    def name(self):
        return self._name

    @property
    def type_(self):
        return self._type_

    @property
    def value(self):
        return self._value

    def get_parameter_value(self):
        """La valeur en message : `.double_value`, `.integer_value`, `.string_value`…"""
        message = ParameterValue(type=self._type_.value)
        if self._type_ is not Parameter.Type.NOT_SET:
            setattr(message, _CHAMPS[self._type_.value][0], self._value)
        return message

    def to_parameter_msg(self):
        return ParameterMsg(name=self._name, value=self.get_parameter_value())

    @classmethod
    def from_parameter_msg(cls, param_msg):
        return cls(param_msg.name, cls.Type(param_msg.value.type), parameter_value_to_python(param_msg.value))

    def __repr__(self):
        return f"Parameter(name={self._name!r}, type={self._type_}, value={self._value!r})"


def parameter_value_to_python(parameter_value):
    """La valeur d'un message, selon son type ; None s'il n'en a pas."""
    if parameter_value.type == ParameterType.PARAMETER_NOT_SET:
        return None
    valeur = getattr(parameter_value, _CHAMPS[parameter_value.type][0])
    return list(valeur) if parameter_value.type in _SUITES else valeur
