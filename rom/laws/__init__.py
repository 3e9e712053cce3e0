"""Contact laws: rigid friction, Eq. (28), and elastic contacts that slide, vary and open.

friction.py            Tanh, Coulomb, and rules for all laws. Start here.
joint_laws.py          Jenkins, Iwan, Sliders
frictional_contact.py  varying normal loads, lift-off
contacts.py            different laws at different contacts
no_contacts.py         the law of models without contacts
elements.py            elastic laws as the core reads them
directions.py          contact DOFs in words, and a check of their directions
law_record.py          laws as plain records, for files
states.py              contacts that stick, slip or are open; energy in their springs
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
