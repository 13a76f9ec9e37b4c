/* Signals that ask a run to end in good order. */
#ifndef TENDRIL_SIGNALS_H
#define TENDRIL_SIGNALS_H

void SignalsCatch(void);
int SignalCaught(void);

#endif
