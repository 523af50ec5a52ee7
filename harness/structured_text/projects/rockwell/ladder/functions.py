"""Functions of timer and counter instructions of ladder, in Structured Text.

A timer counts whole milliseconds from its last execution; the rest of a millisecond counts in the
next execution. `Clock` runs only while the timer is timing. A timer with a negative PRE or ACC
does not run: it would stop the controller with a major fault.

Source: Rockwell 1756-RM003N, pages 118 (TON), 122 (TOF), 127 (RTO), 143 (CTU), 147 (CTD).
"""

from __future__ import annotations

__all__ = ["FUNCTIONS", "USED"]

#: TIME_TO_DINT(T#1s) is 1000 in the dialect of Logix, and 1 in dialects that count seconds.
_TIMED = """\
FUNCTION L5X_TIMED : BOOL
  VAR_IN_OUT Timer : TIMER; END_VAR
  VAR_INPUT Starts : BOOL; END_VAR
  VAR Passed : DINT; END_VAR
  IF Starts THEN
    Timer.Rest := T#0s;
  ELSE
    Timer.Clock(IN := TRUE, PT := T#24d);
    Timer.Rest := Timer.Rest + Timer.Clock.ET;
    Passed := TIME_TO_DINT(Timer.Rest * (1000 / TIME_TO_DINT(T#1s)));
    Timer.Rest := Timer.Rest - T#1ms * Passed;
    IF Timer.ACC > 2147483647 - Passed THEN
      Timer.ACC := 2147483647;
    ELSE
      Timer.ACC := Timer.ACC + Passed;
    END_IF;
  END_IF;
  Timer.Clock(IN := FALSE, PT := T#24d);
  L5X_TIMED := Timer.ACC >= Timer.PRE AND Timer.PRE >= 0;
  IF L5X_TIMED THEN
    Timer.Rest := T#0s;
  ELSE
    Timer.Clock(IN := TRUE, PT := T#24d);
  END_IF;
END_FUNCTION"""
_STOPPED = """\
FUNCTION L5X_STOPPED : BOOL
  VAR_IN_OUT Timer : TIMER; END_VAR
  Timer.Clock(IN := FALSE, PT := T#24d);
  Timer.Rest := T#0s;
  Timer.EN := FALSE;
  Timer.TT := FALSE;
END_FUNCTION"""
_TON = """\
FUNCTION L5X_TON : BOOL
  VAR_IN_OUT Timer : TIMER; END_VAR
  VAR_INPUT Power : BOOL; END_VAR
  IF NOT Power THEN
    L5X_STOPPED(Timer := Timer);
    Timer.DN := FALSE;
    Timer.ACC := 0;
  ELSIF Timer.PRE < 0 OR Timer.ACC < 0 THEN
    L5X_STOPPED(Timer := Timer);
  ELSE
    IF NOT Timer.DN THEN
      Timer.DN := L5X_TIMED(Timer := Timer, Starts := NOT Timer.EN);
    END_IF;
    Timer.EN := TRUE;
    Timer.TT := NOT Timer.DN;
  END_IF;
END_FUNCTION"""
_RTO = _TON.replace("L5X_TON", "L5X_RTO").replace(
    "    Timer.DN := FALSE;\n    Timer.ACC := 0;\n", ""
)
_TOF = """\
FUNCTION L5X_TOF : BOOL
  VAR_IN_OUT Timer : TIMER; END_VAR
  VAR_INPUT Power : BOOL; END_VAR
  IF Power THEN
    L5X_STOPPED(Timer := Timer);
    Timer.EN := TRUE;
    Timer.DN := TRUE;
    Timer.ACC := 0;
  ELSIF Timer.DN AND Timer.PRE >= 0 AND Timer.ACC >= 0 THEN
    Timer.DN := NOT L5X_TIMED(Timer := Timer, Starts := Timer.EN);
    Timer.EN := FALSE;
    Timer.TT := Timer.DN;
  ELSE
    L5X_STOPPED(Timer := Timer);
  END_IF;
END_FUNCTION"""
_CTU = """\
FUNCTION L5X_CTU : BOOL
  VAR_IN_OUT Counter : COUNTER; END_VAR
  VAR_INPUT Power : BOOL; END_VAR
  IF Power AND NOT Counter.CU THEN
    IF Counter.ACC < 2147483647 THEN
      Counter.ACC := Counter.ACC + 1;
    ELSE
      Counter.ACC := -2147483648;
      Counter.OV := NOT Counter.UN;
      Counter.UN := FALSE;
    END_IF;
  END_IF;
  IF Power THEN
    Counter.DN := Counter.OV OR Counter.ACC >= Counter.PRE AND NOT Counter.UN;
  END_IF;
  Counter.CU := Power;
END_FUNCTION"""
_CTD = """\
FUNCTION L5X_CTD : BOOL
  VAR_IN_OUT Counter : COUNTER; END_VAR
  VAR_INPUT Power : BOOL; END_VAR
  IF Power AND NOT Counter.CD THEN
    IF Counter.ACC > -2147483648 THEN
      Counter.ACC := Counter.ACC - 1;
    ELSE
      Counter.ACC := 2147483647;
      Counter.UN := NOT Counter.OV;
      Counter.OV := FALSE;
    END_IF;
  END_IF;
  IF Power THEN
    Counter.DN := Counter.OV OR Counter.ACC >= Counter.PRE AND NOT Counter.UN;
  END_IF;
  Counter.CD := Power;
END_FUNCTION"""
#: The functions, by name.
FUNCTIONS = {
    "L5X_TIMED": _TIMED,
    "L5X_STOPPED": _STOPPED,
    "L5X_TON": _TON,
    "L5X_TOF": _TOF,
    "L5X_RTO": _RTO,
    "L5X_CTU": _CTU,
    "L5X_CTD": _CTD,
}
_TIMING = frozenset(("L5X_TIMED", "L5X_STOPPED", "TIMER"))
#: The functions and types that each function needs.
USED = {
    **dict.fromkeys(("L5X_TON", "L5X_TOF", "L5X_RTO"), _TIMING),
    **dict.fromkeys(("L5X_CTU", "L5X_CTD"), frozenset(("COUNTER",))),
}
