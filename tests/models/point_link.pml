/* SPDX-License-Identifier: Apache-2.0
 *
 * The point link: a host streams the items of a job over carriers that lose, repeat and reorder, to a controller that may
 * lose its power, and the host may die. Each item must be burnt once, in order, and the job must end. README.md says which
 * lines of the code each part stands for. Left out: the counter of messages, which only drops more of what comes late, so
 * that what is proven here holds without it; and what is in an item.
 */
#ifndef ITEMS
#define ITEMS 4
#endif
#ifndef FAULTS
#define FAULTS 2 /* of the carriers */
#endif
#ifndef RESETS
#define RESETS 1 /* power losses of the controller */
#endif
#ifndef HOST_RESETS
#define HOST_RESETS 1
#endif
#define KEPT 2    /* blocks: JobStream::kKept */
#define QUEUE 2   /* items: ItemQueue */
#define LARGEST 2 /* items of a block */
#define WIRE 2    /* messages on their way, each direction */
#define NONE 255

mtype = { ack, missing };
chan to_cell = [WIRE] of { byte, byte };       /* block: first, count; count 0 asks how things stand */
chan to_host = [WIRE] of { mtype, byte, byte }; /* ack: received, free; missing: from, until */

/* The world. */
byte burnt = 0; /* items 0 .. burnt - 1, each once */
byte faults = FAULTS, resets = RESETS, host_resets = HOST_RESETS;
bool done = false;

/* Memory that keeps its content without power (RetainedMemory). */
byte certain = 0, at_most = 0;

/* The controller: JobStream and the ways out of it. */
byte received = 0, kept_end = 0, kept_size = 0;
byte kept_first[KEPT], kept_until[KEPT];
chan queue = [QUEUE] of { byte };
byte released = NONE; /* item whose pulses leave in this window */
bool left = false;    /* they have */
bool ack_due = false, gap_due = false, powered = true;

/* The host: Streamer. */
byte h_received = 0, sent = 0, room = 1;
byte sent_until[ITEMS]; /* end of the unacknowledged block that begins there; 0: none */
byte again_from = 0, again_until = 0;
bool ask = false;

inline find_end() {
    i = 0;
    do
    :: i < kept_size && kept_first[i] <= kept_end ->
        if
        :: kept_until[i] > kept_end -> kept_end = kept_until[i]
        :: else
        fi;
        i++
    :: else -> break
    od
}

inline drop_front() {
    kept_size--;
    i = 0;
    do
    :: i < kept_size -> kept_first[i] = kept_first[i + 1]; kept_until[i] = kept_until[i + 1]; i++
    :: else -> break
    od;
    kept_first[kept_size] = 0;
    kept_until[kept_size] = 0
}

inline keep() {
    i = kept_size;
    do
#ifndef NO_INDEX_CHECK
    :: i > 0 && kept_first[i - 1] > first -> kept_first[i] = kept_first[i - 1]; kept_until[i] = kept_until[i - 1]; i--
#endif
    :: else -> break
    od;
    kept_first[i] = first;
    kept_until[i] = first + count;
    kept_size++;
    find_end()
}

/* JobStream::take */
inline take() {
    ack_due = true;
    gap_due = true;
    known = false;
    if
    :: count == 0 -> known = (first <= kept_end)
    :: else -> known = (first + count <= kept_end)
    fi;
    i = 0;
    do
    :: i < kept_size ->
        known = known || (kept_first[i] <= first && first + count <= kept_until[i] && (count > 0 || kept_first[i] == first));
        i++
    :: else -> break
    od;
#ifdef NO_INDEX_CHECK
    known = (count == 0);
#endif
    fits = false;
    if
#ifdef NO_LAST_PLACE
    :: kept_size < KEPT -> fits = true
#else
    :: kept_size < KEPT && (first <= kept_end || kept_size + 1 < KEPT) -> fits = true
    :: kept_size == KEPT && first <= kept_end && kept_first[KEPT - 1] > kept_end && !known ->
        kept_size--;
        kept_first[kept_size] = 0;
        kept_until[kept_size] = 0;
        fits = true
#endif
    :: else
    fi;
#ifdef ACK_BEFORE_STORE
    if
    :: !known && first == received -> received = first + count
    :: else
    fi;
#endif
    if
    :: !known && fits -> keep()
    :: else
    fi
}

/* JobStream::begin_reading and read_item: the next item of what is kept, when it is the one wanted and has room. */
inline read_item() {
#ifdef NO_INDEX_CHECK
    queue!kept_first[0];
    received = received + 1;
    kept_first[0] = kept_first[0] + 1;
    if
    :: kept_first[0] >= kept_until[0] -> drop_front()
    :: else
    fi
#else
    if
    :: kept_until[0] <= received -> drop_front()
    :: else ->
        queue!received;
        received++;
        if
        :: kept_end < received -> kept_end = received
        :: else
        fi;
        if
        :: kept_until[0] <= received -> drop_front()
        :: else
        fi
    fi
#endif
}

/* JobStream::window */
#define BLOCKS_ROOM (kept_end - received + (KEPT - kept_size) * LARGEST)
#define QUEUE_ROOM (QUEUE - len(queue))
#define WINDOW ((BLOCKS_ROOM) < (QUEUE_ROOM) -> (BLOCKS_ROOM) : (QUEUE_ROOM))
#ifdef NO_INDEX_CHECK
#define READABLE (kept_size > 0)
#else
#define READABLE (kept_size > 0 && kept_first[0] <= received)
#endif

/* Endpoint::transmit: the ack first; what has no room stays due. */
inline transmit() {
    if
    :: ack_due && len(to_host) < WIRE -> to_host!ack,received,WINDOW; ack_due = false
    :: else
    fi;
#ifdef MINOR_0
    gap_due = false;
#else
    if
    :: gap_due && len(to_host) < WIRE ->
        i = 0;
        do
        :: i < kept_size && kept_first[i] <= kept_end -> i++
        :: else -> break
        od;
        if
        :: i < kept_size && kept_size < KEPT -> to_host!missing,kept_end,kept_first[i]
        :: else
        fi;
        gap_due = false
    :: else
    fi;
#endif
    i = 0
}

inline read_items() {
    do
    :: READABLE && len(queue) < QUEUE -> read_item()
    :: else -> break
    od
}

/* A tick is one step: what has come, items, what is due. Between two ticks pulses leave. */
proctype cell() {
    byte first, count, i;
    bool known, fits;
    do
    :: atomic { powered && len(to_cell) > 0 ->
        to_cell?first,count;
        take();
        read_items();
        transmit();
        first = 0; count = 0; known = false; fits = false }
    :: atomic { powered && ack_due && len(to_host) < WIRE -> transmit() }
    /* `at_most` (JobRecord::reached) is written before the outputs of a tick are released, `certain` when they have acted. */
    :: atomic { powered && released == NONE && len(queue) > 0 ->
        queue?released;
        read_items();
        ack_due = true;
        transmit();
#ifndef RECORD_AFTER
        at_most = released + 1
#endif
        }
    :: atomic { powered && released != NONE && !left ->
        assert(released == burnt); /* in order, none missing, none twice */
        burnt++;
        left = true }
    :: atomic { powered && released != NONE && left ->
        certain = released + 1;
#ifdef RECORD_AFTER
        at_most = certain;
#endif
        released = NONE;
        left = false;
        done = (certain == ITEMS) }
    :: done -> break
    od
}

/* hello, position, job_resume: requests are repeated until they are answered and done at most once (ReplyMemory), so they
 * are one step here. What was on its way from a controller that has lost its power is lost with it. */
inline power_loss() {
    received = 0; kept_end = 0; kept_size = 0;
    kept_first[0] = 0; kept_first[1] = 0; kept_until[0] = 0; kept_until[1] = 0;
    do
    :: len(queue) > 0 -> queue?_
    :: len(queue) == 0 -> break
    od;
    do
    :: len(to_host) > 0 -> to_host?_,_,_
    :: len(to_host) == 0 -> break
    od;
    released = NONE; left = false; ack_due = false; gap_due = false
}

inline forget() {
    j = 0;
    do
    :: j < ITEMS -> sent_until[j] = 0; j++
    :: else -> break
    od;
    again_from = 0; again_until = 0; ask = false; room = 1
}

proctype host() {
    byte a, b, j;
    mtype kind;
    do
    :: atomic { powered && len(to_host) > 0 -> to_host?kind,a,b;
        if
        :: kind == ack && a >= h_received ->
            h_received = a;
            room = b;
            j = 0;
            do
            :: j < ITEMS ->
                if
                :: sent_until[j] <= h_received -> sent_until[j] = 0
                :: else
                fi;
                j++
            :: else -> break
            od;
            if
            :: sent < h_received -> sent = h_received
            :: else
            fi
        :: kind == missing ->
            again_from = (a > h_received -> a : h_received);
            again_until = (b < sent -> b : sent)
        :: else
        fi;
        a = 0; b = 0; j = 0 }
    /* send_window; blocks may be cut as one likes */
    :: atomic { powered && sent < ITEMS && sent < h_received + room && len(to_cell) < WIRE ->
        if
        :: j = 1
        :: sent + 2 <= ITEMS && sent + 2 <= h_received + room -> j = 2
        fi;
        sent_until[sent] = sent + j;
        to_cell!sent,j;
        sent = sent + j;
        j = 0 }
    /* resend_missing */
    :: atomic { powered && again_from < again_until && len(to_cell) < WIRE ->
        j = again_from;
        do
        :: sent_until[j] == 0 && j > 0 -> j--
        :: else -> break
        od;
        if
        :: sent_until[j] > again_from ->
            to_cell!j,sent_until[j] - j;
            again_from = sent_until[j]
        :: else -> again_from = again_until /* acknowledged since */
        fi;
        j = 0 }
    /* resend_when_silent */
    :: atomic { powered && ask && len(to_cell) < WIRE ->
#ifdef MINOR_0
        sent = h_received;
#else
        to_cell!sent,0;
#endif
        ask = false }
    /* known_place, resume_point: certain and at_most from the controller; where they differ a person looks at the part. */
    :: atomic { !powered ->
#ifdef RESUME_FROM_JOURNAL
        j = sent;
#else
        if
        :: certain == at_most -> j = certain
        :: else -> j = burnt; assert(certain <= burnt && burnt <= at_most)
        fi;
#endif
        received = j; kept_end = j; /* open_at */
        h_received = j; sent = j;   /* begin_at */
        certain = j; at_most = j;
        done = (j == ITEMS);
        forget();
        j = 0;
        powered = true }
    /* The host is killed and another takes over (Session::take_over). */
    :: atomic { powered && !done && host_resets > 0 ->
        host_resets--;
        h_received = received;
        sent = received;
        forget();
        ack_due = true;
        j = 0 }
    :: done -> break
    od
}

proctype world() {
    byte a, b;
    mtype kind;
    do
    :: atomic { faults > 0 && len(to_cell) > 0 -> to_cell?a,b; faults--; a = 0; b = 0 }                                 /* lost */
    :: atomic { faults > 0 && len(to_cell) > 0 && len(to_cell) < WIRE -> to_cell?<a,b>; to_cell!a,b; faults--; a = 0; b = 0 } /* twice, late */
    :: atomic { faults > 0 && len(to_cell) > 1 -> to_cell?a,b; to_cell!a,b; faults--; a = 0; b = 0 }   /* out of order */
    :: atomic { faults > 0 && len(to_host) > 0 -> to_host?kind,a,b; faults--; a = 0; b = 0 }
    :: atomic { faults > 0 && len(to_host) > 0 && len(to_host) < WIRE -> to_host?<kind,a,b>; to_host!kind,a,b; faults--; a = 0; b = 0 }
    :: atomic { faults > 0 && len(to_host) > 1 -> to_host?kind,a,b; to_host!kind,a,b; faults--; a = 0; b = 0 }
    :: atomic { powered && !done && resets > 0 -> resets--; powered = false; power_loss() }
    /* Nothing else happens: the controller repeats its ack, and a host that still waits asks. */
    :: atomic { timeout && !done ->
#ifndef NEVER_ASKS
        ask = (sent > h_received);
#endif
        ack_due = true }
    :: done -> break
    od
}

init { atomic { run cell(); run host(); run world() } }

#ifdef LIVENESS
ltl ends { <> done }
#endif
