/* What an importer looks up and the regression does not have. Without the header: none of these is
   called, so their arguments do not matter. */

enum { ERROR = 3 };

int fmi2SetDebugLogging(void) { return ERROR; }
int fmi2GetInteger(void) { return ERROR; }
int fmi2GetBoolean(void) { return ERROR; }
int fmi2GetString(void) { return ERROR; }
int fmi2SetInteger(void) { return ERROR; }
int fmi2SetBoolean(void) { return ERROR; }
int fmi2SetString(void) { return ERROR; }
int fmi2GetFMUstate(void) { return ERROR; }
int fmi2SetFMUstate(void) { return ERROR; }
int fmi2FreeFMUstate(void) { return ERROR; }
int fmi2SerializedFMUstateSize(void) { return ERROR; }
int fmi2SerializeFMUstate(void) { return ERROR; }
int fmi2DeSerializeFMUstate(void) { return ERROR; }
int fmi2GetDirectionalDerivative(void) { return ERROR; }
int fmi2SetRealInputDerivatives(void) { return ERROR; }
int fmi2GetRealOutputDerivatives(void) { return ERROR; }
int fmi2CancelStep(void) { return ERROR; }
int fmi2GetStatus(void) { return ERROR; }
int fmi2GetRealStatus(void) { return ERROR; }
int fmi2GetIntegerStatus(void) { return ERROR; }
int fmi2GetBooleanStatus(void) { return ERROR; }
int fmi2GetStringStatus(void) { return ERROR; }
