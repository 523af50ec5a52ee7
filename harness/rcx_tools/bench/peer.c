/*
 * The peer of cost.py: what a C programmer writes by hand for the same robot.
 *
 * The same exchanges as the ST library makes: status, response and dedicated outputs out of the
 * process image, turns, time limits, refused inputs, the handshake of the remote commands, the
 * interval between dedicated inputs, code, data and dedicated inputs into the process image; with
 * the pins that a user of the blocks sees. Shared code is shared, and nothing is copied that a
 * pointer can reach. cost.py replays the same inputs to both sides and compares all outputs.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { INTERVAL_US = 250000, SETTLING_US = 400000, NEVER = -1 };
enum { SI_EMG = 0x0001, SI_SERVO = 0x0002, SI_STOP = 0x0040, SI_START = 0x0400, SI_RESET = 0x2000,
       SI_ALARM_RESET = 0x4000 };
enum { SO_EMG = 0x0001, SO_CPU = 0x0002, SO_SERVO = 0x0004, SO_ALARM = 0x0008, SO_MP = 0x0010,
       SO_AUTO = 0x0100, SO_RUNNING = 0x0800, SO_RESET = 0x1000 };
enum phase { STATUS_RESET, READY, COMMAND_DATA, COMMAND_RUN };

struct channel { uint16_t next, serving, holder; bool alive, orphan; };

struct robot {
  bool connected, settled, running, code_request, was_up, lost;
  uint16_t status, response[16], so, si, request, code, data[16], general[16], owner;
  enum phase phase;
  struct channel command, sequence;
  int64_t now, paced, settled_since, recovery;
};

struct pins { bool execute, done, busy, active, error; uint16_t error_id; };

struct job {
  bool was_execute, armed, counts;
  uint16_t ticket;
  int64_t since, longest;
};

/* What differs from job to job in one scan. */
struct work {
  bool applied, answered, settled, remote;
  uint16_t holder, offline, trouble, answer;
};

/* Returns whether the work has ended; *request says whether it is to be asked for. */
static bool job_run(struct job *j, struct pins *p, struct channel *c, const struct work *w,
                    int64_t now, int64_t longest, bool *request) {
  bool may_end = p->busy, ended = false, released = false;
  *request = false;
  if (!p->busy && (!p->execute || !j->was_execute)) {
    p->done = p->error = false;
    p->error_id = 0;
    if (p->execute) {
      p->busy = true;
      j->ticket = c->next++;
      j->armed = j->counts = false;
      j->longest = longest;
    }
  }
  j->was_execute = p->execute;
  if (!p->busy) return false;
  uint16_t ahead = (uint16_t)(j->ticket - c->serving);
  if (ahead > 32767 || (p->active && (ahead || c->orphan))) {
    released = true;
  } else if (!ahead) {
    if (!p->active) j->counts = false;
    p->active = c->alive = true;
    c->holder = w->holder;
    j->armed |= !w->applied;
  }
  if (!p->active && !c->orphan) {
    j->counts = false;
  } else if (!j->counts) {
    j->counts = true;
    j->since = now;
  }
  if (may_end) {
    bool late = j->counts && j->longest && now - j->since >= j->longest;
    ended = true;
    if (released) p->error_id = 0x8013;
    else if (w->offline) p->error_id = w->offline;
    else if (w->trouble && (w->remote || (p->active && ((j->armed && w->applied) || w->settled))))
      p->error_id = w->trouble;
    else if (p->active && j->armed && w->applied && w->answered) p->error_id = w->answer;
    else if (!late) ended = false;
    else if (!p->active) p->error_id = 0x8012;
    else if (w->trouble) p->error_id = w->trouble;
    else p->error_id = !w->remote ? 0x8010 : w->applied ? 0x8011 : 0x8015;
  }
  if (!ended) {
    *request = p->active && j->armed && !w->offline && (!w->trouble || w->applied)
      && !(w->remote && w->applied);
    return false;
  }
  if (p->active && !released) {
    if (w->remote && w->applied && !(j->armed && w->answered)) {
      c->orphan = true;
    } else {
      c->serving++;
      c->holder = 0;
    }
  }
  p->busy = p->active = false;
  p->error = p->error_id != 0;
  p->done = !p->error;
  return true;
}

/* --- sequences of dedicated inputs --- */

struct sequence { struct pins pins; int64_t timeout; struct job job; };

static void sequence_run(struct sequence *s, struct robot *r, uint16_t input, uint16_t holder,
                         bool answered, uint16_t trouble) {
  bool request;
  struct work w = { (r->si & input) != 0, answered, r->settled, false, holder,
                    r->connected ? 0 : 0x8001, trouble, 0 };
  job_run(&s->job, &s->pins, &r->sequence, &w, r->now, s->timeout, &request);
  if (request) r->request |= input;
}

void servo_on(struct sequence *s, struct robot *r) {
  uint16_t trouble = !(r->so & SO_CPU) ? 0x8002 : (r->so & SO_EMG) ? 0x8003
    : (r->so & SO_ALARM) ? 0x8004 : !(r->so & SO_MP) ? 0x8005 : 0;
  sequence_run(s, r, SI_SERVO, 0x01, r->so & SO_SERVO, trouble);
}

void alarm_reset(struct sequence *s, struct robot *r) {
  sequence_run(s, r, SI_ALARM_RESET, 0x16, !(r->so & SO_ALARM), r->so & SO_EMG ? 0x8003 : 0);
}

void program_reset(struct sequence *s, struct robot *r) {
  uint16_t trouble = !(r->so & SO_CPU) ? 0x8002 : !(r->so & SO_AUTO) ? 0x8006 : 0;
  sequence_run(s, r, SI_RESET, 0x15, r->so & SO_RESET, trouble);
}

void auto_start(struct sequence *s, struct robot *r) {
  uint16_t trouble = !(r->so & SO_CPU) ? 0x8002 : (r->so & SO_EMG) ? 0x8003
    : (r->so & SO_ALARM) ? 0x8004 : !(r->so & SO_AUTO) ? 0x8006
    : (r->so & SO_RUNNING) && !(r->si & SI_START) ? 0x8008 : 0;
  sequence_run(s, r, SI_START, 0x12, r->so & SO_RUNNING, trouble);
}

/* --- remote commands --- */

struct command {
  struct pins pins;
  uint16_t alarm_group, alarm_category, code, data[16], refused;
  int64_t timeout;
  struct job job;
};

static bool command_idle(const struct command *c) {
  return !(c->pins.execute || c->pins.busy || c->pins.done || c->pins.error);
}

static bool command_run(struct command *c, struct robot *r) {
  bool request, over = true;
  uint16_t answer = 0;
  if (r->status == 0x4000) answer = 0x8020;
  else if (r->status == 0 && r->running) answer = 0x8014;
  else over = r->status == 0x0200;
  struct work w = { r->phase == COMMAND_RUN, over, true, true, c->code,
                    !r->connected ? 0x8001 : !(r->so & SO_CPU) ? 0x8002 : 0, c->refused, answer };
  bool ended = job_run(&c->job, &c->pins, &r->command, &w, r->now, c->timeout, &request);
  if (request) {
    r->code = c->code;
    memcpy(r->data, c->data, sizeof r->data);
    r->code_request = true;
  }
  if (c->pins.error_id != 0x8020) {
    c->alarm_group = c->alarm_category = 0;
  } else if (ended) {
    c->alarm_group = r->response[1];
    c->alarm_category = r->response[2];
  }
  return ended;
}

static int32_t number(const uint16_t *words) {
  return (int32_t)((uint32_t)words[0] | (uint32_t)words[1] << 16);
}

enum speed_mode { SPEED_PROGRAM, SPEED_DIRECT, SPEED_PERCENT, SPEED_MM_S };
enum output { POSITION_NONE, POSITION_PULSES, POSITION_MM };

struct move_ptp {
  struct command command;
  int16_t robot_number, point, acceleration, deceleration;
  uint16_t axes;
  enum speed_mode speed_mode;
  enum output output;
  float speed;
  int32_t pulses[6];
  float position[6];
};

static uint16_t move_refused(const struct move_ptp *m) {
  if (m->robot_number < 0 || m->robot_number > 4) return 0x8040;
  if (m->axes & 0xFFC0) return 0x8041;
  if (m->point < 0 || m->point > 29999) return 0x8044;
  if (m->speed_mode == SPEED_MM_S) return 0x8042;
  if (m->speed_mode == SPEED_DIRECT && !(m->speed >= 0.009f && m->speed <= 100.0f)) return 0x8042;
  if (m->speed_mode == SPEED_PERCENT && !(m->speed >= 1.0f && m->speed <= 100.0f)) return 0x8042;
  if (m->acceleration && (m->acceleration < 1 || m->acceleration > 100)) return 0x8043;
  if (m->deceleration && (m->deceleration < 1 || m->deceleration > 100)) return 0x8043;
  return 0;
}

void move_ptp(struct move_ptp *m, struct robot *r) {
  struct command *c = &m->command;
  if (command_idle(c)) return;
  if (c->pins.execute && !c->pins.busy) {
    c->code = (uint16_t)(0x0001 | m->robot_number << 12);
    c->refused = move_refused(m);
    if (!c->refused) {
      uint16_t flags = m->axes ? 1 : 0;
      memset(c->data, 0, sizeof c->data);
      c->data[2] = m->axes;
      c->data[4] = (uint16_t)m->point;
      if (m->speed_mode == SPEED_DIRECT) {
        flags |= 2;
        c->data[3] = (uint16_t)lrintf(m->speed * 100.0f);
      } else if (m->speed_mode == SPEED_PERCENT) {
        flags |= 4;
        c->data[3] = (uint16_t)lrintf(m->speed);
      }
      if (m->acceleration) flags |= 0x20;
      if (m->deceleration) flags |= 0x40;
      c->data[10] = (uint16_t)m->acceleration;
      c->data[11] = (uint16_t)m->deceleration;
      flags |= m->output == POSITION_PULSES ? 0x4000 : m->output == POSITION_MM ? 0x8000 : 0;
      c->data[1] = flags;
    }
  }
  if (command_run(c, r)) {
    for (int k = 0; k < 6; k++) {
      int32_t value = number(&r->response[2 * k + 4]);
      m->pulses[k] = c->pins.done && (c->data[1] & 0x4000) ? value : 0;
      m->position[k] = c->pins.done && (c->data[1] & 0x8000) ? (float)value / 1000.0f : 0;
    }
  }
}

struct read_position { struct command command; int16_t robot_number; int32_t pulses[6]; };

void read_position(struct read_position *p, struct robot *r) {
  struct command *c = &p->command;
  if (command_idle(c)) return;
  if (c->pins.execute && !c->pins.busy) {
    c->code = (uint16_t)(0x0505 | p->robot_number << 12);
    c->refused = p->robot_number < 0 || p->robot_number > 4 ? 0x8040 : 0;
    c->data[1] = 0;
  }
  if (command_run(c, r))
    for (int k = 0; k < 6; k++)
      p->pulses[k] = c->pins.done ? number(&r->response[2 * k + 4]) : 0;
}

/* --- the process image --- */

static uint16_t word(const uint8_t *image, int k) {
  return (uint16_t)(image[2 * k] | image[2 * k + 1] << 8);
}

void read_area(struct robot *r, const uint8_t *image, bool connected) {
  r->connected = connected;
  r->so = 0;
  r->status = 0;
  memset(r->response, 0, sizeof r->response);
  if (!connected) return;
  r->status = word(image, 0);
  for (int k = 1; k <= 15; k++) r->response[k] = word(image, k);
  r->so = word(image, 16);
}

static void handshake(struct robot *r) {
  bool up = r->connected && (r->so & SO_CPU) && !r->lost;
  r->lost = false;
  if (!up) r->recovery = NEVER;
  else if (r->recovery == NEVER) r->recovery = r->now;
  if (!up || r->now - r->recovery < INTERVAL_US) {
    r->phase = STATUS_RESET;
  } else if (r->phase == COMMAND_RUN) {
    uint16_t code = r->code & 0x0FFF;
    bool endless = (code == 0x0505 || code == 0x0506) && (r->data[1] & 1);
    if (r->status == 0x0200 || r->status == 0x4000) {
      r->phase = STATUS_RESET;
    } else if (endless && r->status == 0x0100 && (r->command.orphan || !r->command.alive)) {
      r->phase = STATUS_RESET;
    } else if (r->status) {
      r->running = true;
    } else if (r->running) {
      r->lost = true;
      r->phase = STATUS_RESET;
    }
  } else if (r->status == 0) {
    if (!r->code_request) {
      r->phase = READY;
    } else if (r->phase == COMMAND_DATA && r->owner == r->command.serving) {
      r->phase = COMMAND_RUN;
      r->running = false;
    } else {
      r->phase = COMMAND_DATA;
      r->owner = r->command.serving;
    }
  } else {
    r->phase = STATUS_RESET;
  }
  r->code_request = false;
  struct channel *c = &r->command;
  if (c->serving != c->next) {
    if (r->phase == COMMAND_RUN) {
      c->orphan |= !c->alive;
    } else if (c->orphan || !c->alive) {
      c->serving++;
      c->orphan = false;
      c->holder = 0;
    }
  }
  c->alive = false;
}

static void dedicated_inputs(struct robot *r, bool emergency_ok, bool stop_ok) {
  static const uint16_t off[] = { 0x0002, 0x0100, 0x0400, 0x1000, 0x2000, 0x4000, 0x8000 };
  static const uint16_t on[] = { SI_EMG, SI_STOP, 0x0002, 0x0100, 0x0400, 0x1000, 0x2000, 0x4000,
                                 0x8000 };
  if (emergency_ok && r->connected) r->request |= SI_EMG;
  if (stop_ok && r->connected) r->request |= SI_STOP;
  bool safety = r->connected && !r->was_up;
  r->was_up = r->connected;
  uint16_t withdrawn = r->si & ~r->request & (SI_EMG | SI_STOP);
  if (withdrawn) {
    r->si &= (uint16_t)~withdrawn;
    safety = true;
  }
  bool changed = safety;
  if (!safety && r->now - r->paced >= INTERVAL_US && r->si != r->request) {
    for (unsigned k = 0; k < sizeof off / sizeof *off && !changed; k++)
      if (r->si & ~r->request & off[k]) {
        r->si ^= off[k];
        changed = true;
      }
    for (unsigned k = 0; k < sizeof on / sizeof *on && !changed; k++)
      if (r->request & ~r->si & on[k]) {
        r->si ^= on[k];
        changed = true;
        safety = on[k] & (SI_EMG | SI_STOP);
      }
  }
  if (changed) r->paced = r->now;
  if (safety) r->settled_since = r->now;
  r->settled = r->now - r->settled_since >= SETTLING_US
    && !((r->si ^ r->request) & (SI_EMG | SI_STOP));
  r->request = 0;
  struct channel *c = &r->sequence;
  if (c->serving != c->next && !c->alive) {
    c->serving++;
    c->holder = 0;
  }
  c->alive = false;
}

void write_area(struct robot *r, uint8_t *image, bool emergency_ok, bool stop_ok) {
  uint16_t words[17] = { 0 };
  handshake(r);
  dedicated_inputs(r, emergency_ok, stop_ok);
  if (r->phase == COMMAND_RUN) words[0] = r->code;
  if (r->phase == COMMAND_DATA || r->phase == COMMAND_RUN)
    memcpy(words + 1, r->data + 1, 30);
  else
    memcpy(words + 2, r->general + 2, 28);
  words[16] = r->si;
  for (int k = 0; k <= 16; k++) {
    image[2 * k] = (uint8_t)words[k];
    image[2 * k + 1] = (uint8_t)(words[k] >> 8);
  }
}

/* --- the programs: example 01, and 50 commands that wait for their Execute --- */

enum stage { IDLE, RESET_ALARM, SERVO, RESET_PROGRAM, START_PROGRAM, PROGRAM, MOVE, POSITION,
             COMPLETE, FAULT };

static struct {
  struct robot robot;
  struct sequence alarm_reset, servo_on, program_reset, auto_start;
  struct move_ptp move;
  struct read_position position;
  enum stage stage;
  uint16_t fault;
  int32_t axis1;
  struct move_ptp moves[50];
} plant;

static void begin(int64_t now) {
  memset(&plant, 0, sizeof plant);
  plant.robot.recovery = NEVER;
  plant.robot.paced = plant.robot.settled_since = now;
  plant.alarm_reset.timeout = plant.servo_on.timeout = 5000000;
  plant.program_reset.timeout = plant.auto_start.timeout = 5000000;
  plant.position.command.timeout = 5000000;
  for (int k = 0; k < 50; k++) plant.moves[k].command.timeout = 60000000;
}

void demo_scan(bool connected, bool start, const uint8_t *in, uint8_t *out, int64_t now) {
  struct robot *r = &plant.robot;
  enum stage stage = plant.stage;
  r->now = now;
  read_area(r, in, connected);
  plant.alarm_reset.pins.execute = stage == RESET_ALARM;
  alarm_reset(&plant.alarm_reset, r);
  plant.servo_on.pins.execute = stage == SERVO;
  servo_on(&plant.servo_on, r);
  plant.program_reset.pins.execute = stage == RESET_PROGRAM;
  program_reset(&plant.program_reset, r);
  plant.auto_start.pins.execute = stage == START_PROGRAM;
  auto_start(&plant.auto_start, r);
  plant.move.command.pins.execute = stage == MOVE;
  plant.move.point = 19;
  plant.move.speed_mode = SPEED_PERCENT;
  plant.move.speed = 50.0f;
  plant.move.command.timeout = 10000000;
  move_ptp(&plant.move, r);
  plant.position.command.pins.execute = stage == POSITION;
  read_position(&plant.position, r);
  plant.fault = plant.alarm_reset.pins.error_id | plant.servo_on.pins.error_id
    | plant.program_reset.pins.error_id | plant.auto_start.pins.error_id
    | plant.move.command.pins.error_id | plant.position.command.pins.error_id;
  if (plant.fault) stage = FAULT;
  else if (stage == IDLE && start) stage = r->so & SO_ALARM ? RESET_ALARM : SERVO;
  else if (plant.alarm_reset.pins.done) stage = SERVO;
  else if (plant.servo_on.pins.done) stage = RESET_PROGRAM;
  else if (plant.program_reset.pins.done) stage = START_PROGRAM;
  else if (plant.auto_start.pins.done) stage = PROGRAM;
  else if (stage == PROGRAM && !(r->so & SO_RUNNING)) stage = MOVE;
  else if (plant.move.command.pins.done) stage = POSITION;
  else if (plant.position.command.pins.done) {
    plant.axis1 = plant.position.pulses[0];
    stage = COMPLETE;
  }
  plant.stage = stage;
  write_area(r, out, true, true);
}

void idle_scan(bool connected, bool start, const uint8_t *in, uint8_t *out, int64_t now) {
  struct robot *r = &plant.robot;
  r->now = now;
  read_area(r, in, connected);
  for (int k = 0; k < 50; k++) {
    plant.moves[k].command.pins.execute = start;
    plant.moves[k].point = 19;
    move_ptp(&plant.moves[k], r);
  }
  write_area(r, out, true, true);
}
