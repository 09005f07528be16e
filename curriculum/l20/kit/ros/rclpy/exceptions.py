"""Les exceptions de rclpy."""


class NotInitializedException(Exception):
    """On s'est servi de rclpy avant `rclpy.init()`."""

    def __init__(self, message=None):
        super().__init__("rclpy.init() has not been called" + (f". msg:{message}" if message else ""))


class NameValidationException(Exception):
    sorte = "name"

    def __init__(self, nom, raison, place=0):
        super().__init__(f"Invalid {self.sorte}: {raison}:\n  '{nom}'\n   {' ' * place}^")


class InvalidNodeNameException(NameValidationException):
    sorte = "node name"


class InvalidNamespaceException(NameValidationException):
    sorte = "namespace"


class InvalidTopicNameException(NameValidationException):
    sorte = "topic name"


class ParameterException(Exception):
    def __init__(self, raison, parametre):
        super().__init__(f"{raison}: {parametre}")


class ParameterNotDeclaredException(ParameterException):
    def __init__(self, parametre):
        super().__init__("Invalid access to undeclared parameter(s)", parametre)


class ParameterAlreadyDeclaredException(ParameterException):
    def __init__(self, parametres):
        super().__init__("Parameter(s) already declared", parametres)


class InvalidParameterException(ParameterException):
    def __init__(self, nom):
        super().__init__("Invalid parameter name", nom)


class InvalidParameterTypeException(ParameterException):
    def __init__(self, parametre, attendu):
        raison = f"Trying to set parameter '{parametre.name}' to '{parametre.value}' of type"
        super().__init__(f"{raison} '{parametre.type_.name}', expecting type '{attendu}'", parametre.name)


class InvalidParameterValueException(ParameterException):
    def __init__(self, nom, valeur, raison):
        super().__init__(f"Invalid parameter value ({valeur}) for parameter. Reason: {raison}", nom)


class ParameterImmutableException(ParameterException):
    def __init__(self, nom):
        super().__init__("Attempted to modify read-only parameter", nom)


class ParameterUninitializedException(ParameterException):
    def __init__(self, nom):
        super().__init__(f"The parameter '{nom}' is not initialized", nom)


class ROSInterruptException(Exception):
    def __init__(self):
        super().__init__("rclpy.shutdown() has been called")
