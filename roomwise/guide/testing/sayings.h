#pragma once

#include <array>
#include <string_view>
#include <utility>

// What people say who are asked back, led, or want to take back what they said, and what they ask
// of what is beside them. Written down before the corrections of the catalogues were. A line each:
// what was before, what they say, and what they mean as dialogue_test.cpp tells it.
//
//   N  nothing
//   Q  "where is the table" was answered
//   L  is led to the kitchen, and asked for it by name
//   P  likewise, then asked where the table is
//   W  bedroom 1 (to the left, nearer) or bedroom 2?
//   X  is led to bedroom 1, chosen of these
//   M  the chair in the kitchen (to the left, nearer) or in the living room?
//   D  did they mean the kitchen?
namespace roomwise::guide::testing {

// clang-format off
// All of these must be understood.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kSayings{{
    {"en", R"(
L|no, the bathroom|take_me_to bathroom
L|no, to the bathroom|take_me_to bathroom
L|not the kitchen, the bathroom|take_me_to bathroom
L|I meant the living room|take_me_to living room
L|no, take me to the hall|take_me_to corridor
L|sorry, the hall|take_me_to corridor
L|the bathroom instead|take_me_to bathroom
L|not to the kitchen|pause
L|no|pause
L|cancel that|end
L|no no stop|end
L|no, the bedroom|which one: take_me_to bedroom 1 bedroom 2
L|no, the bathrom|did you mean: take_me_to bathroom
P|no, the sofa|where_is sofa
Q|no, the sofa|where_is sofa
Q|not the table, the lamp|where_is lamp
W|the other one|offer
W|the left one|take_me_to bedroom 1
W|the one on the right|take_me_to bedroom 2
W|the nearer one|take_me_to bedroom 1
W|neither|declined
W|the third one|offer
W|cancel that|declined
W|not the first one|take_me_to bedroom 2
M|not in the kitchen|take_me_to chair in living room
M|no, the one in the living room|take_me_to chair in living room
M|the bathroom|offer
D|no, the hall|take_me_to corridor
X|the other one|take_me_to bedroom 2
X|no, the second one|take_me_to bedroom 2
N|what is on my left|what_is_left
N|what is to my right|what_is_right
N|what is behind me|what_is_behind
N|what is in front of me|what_is_ahead
N|is there anything ahead|what_is_ahead
N|where can I sit|where_to_sit
N|is the way free|what_is_ahead
N|where is my watch|unknown: where_is watch
)"},
    {"de", R"(
L|nein, das Bad|take_me_to bathroom
L|nein, ins Bad|take_me_to bathroom
L|nicht in die Küche, ins Bad|take_me_to bathroom
L|ich meinte das Wohnzimmer|take_me_to living room
L|nein, bring mich in den Flur|take_me_to corridor
L|doch lieber in den Flur|take_me_to corridor
L|nicht die Küche, sondern das Bad|take_me_to bathroom
L|nicht in die Küche|pause
L|nein|pause
L|brich das ab|end
L|nein nein stopp|end
L|nein, ins Schlafzimmer|which one: take_me_to bedroom 1 bedroom 2
L|nein, ins Wohnzimer|did you mean: take_me_to living room
P|nein, das Sofa|where_is sofa
Q|nein, das Sofa|where_is sofa
Q|nicht der Tisch, die Lampe|where_is lamp
W|das andere|offer
W|das linke|take_me_to bedroom 1
W|das auf der rechten Seite|take_me_to bedroom 2
W|das nähere|take_me_to bedroom 1
W|keins von beiden|declined
W|das dritte|offer
W|abbrechen|declined
W|nicht das erste|take_me_to bedroom 2
M|nicht in der Küche|take_me_to chair in living room
M|nein, der im Wohnzimmer|take_me_to chair in living room
M|im Bad|offer
D|nein, der Flur|take_me_to corridor
X|das andere|take_me_to bedroom 2
X|nein, das zweite|take_me_to bedroom 2
N|was ist links von mir|what_is_left
N|was ist rechts neben mir|what_is_right
N|was ist hinter mir|what_is_behind
N|was ist vor mir|what_is_ahead
N|ist da vorne etwas|what_is_ahead
N|wo kann ich mich hinsetzen|where_to_sit
N|ist der Weg frei|what_is_ahead
N|wo ist meine Armbanduhr|unknown: where_is Armbanduhr
N|bring mich in die Kueche|take_me_to kitchen
N|wo ist der Kuehlschrank|where_is fridge
)"},
    {"es", R"(
L|no, al baño|take_me_to bathroom
L|no, el baño|take_me_to bathroom
L|a la cocina no, al baño|take_me_to bathroom
L|quería decir el salón|take_me_to living room
L|no, llévame al pasillo|take_me_to corridor
L|perdón, el pasillo|take_me_to corridor
L|mejor al baño|take_me_to bathroom
L|a la cocina no|pause
L|no|pause
L|cancela eso|end
L|no no para|end
L|no, al dormitorio|which one: take_me_to bedroom 1 bedroom 2
L|no, al pasilo|did you mean: take_me_to corridor
P|no, el sofá|where_is sofa
Q|no, el sofá|where_is sofa
Q|la mesa no, la lámpara|where_is lamp
W|el otro|offer
W|el de la izquierda|take_me_to bedroom 1
W|el de la derecha|take_me_to bedroom 2
W|el más cercano|take_me_to bedroom 1
W|ninguno|declined
W|el tercero|offer
W|cancela eso|declined
W|el primero no|take_me_to bedroom 2
M|en la cocina no|take_me_to chair in living room
M|no, la del salón|take_me_to chair in living room
M|en el baño|offer
D|no, el pasillo|take_me_to corridor
X|el otro|take_me_to bedroom 2
X|no, el segundo|take_me_to bedroom 2
N|qué hay a mi izquierda|what_is_left
N|qué tengo a la derecha|what_is_right
N|qué hay detrás de mí|what_is_behind
N|qué hay delante de mí|what_is_ahead
N|hay algo delante|something_ahead
N|dónde puedo sentarme|where_to_sit
N|está libre el camino|what_is_ahead
N|dónde está mi reloj de pulsera|unknown: where_is reloj de pulsera
N|qué hay en la mesa|what_is_on table
N|que hay sobre la mesa|what_is_on table
)"},
    {"fr", R"(
L|non, la salle de bain|take_me_to bathroom
L|non, à la salle de bain|take_me_to bathroom
L|pas la cuisine, la salle de bain|take_me_to bathroom
L|je voulais dire le salon|take_me_to living room
L|non, emmène-moi dans le couloir|take_me_to corridor
L|pardon, le couloir|take_me_to corridor
L|plutôt la salle de bain|take_me_to bathroom
L|pas à la cuisine|pause
L|non|pause
L|annule ça|end
L|non non arrête|end
L|non, la chambre|which one: take_me_to bedroom 1 bedroom 2
L|non, le couloirr|did you mean: take_me_to corridor
P|non, le canapé|where_is sofa
Q|non, le canapé|where_is sofa
Q|pas la table, la lampe|where_is lamp
W|l'autre|offer
W|celle de gauche|take_me_to bedroom 1
W|celle de droite|take_me_to bedroom 2
W|la plus proche|take_me_to bedroom 1
W|aucune|declined
W|la troisième|offer
W|annule ça|declined
W|pas la première|take_me_to bedroom 2
M|pas dans la cuisine|take_me_to chair in living room
M|non, celle du salon|take_me_to chair in living room
M|dans la salle de bain|offer
D|non, le couloir|take_me_to corridor
X|l'autre|take_me_to bedroom 2
X|non, la deuxième|take_me_to bedroom 2
N|qu'y a-t-il à ma gauche|what_is_left
N|qu'est-ce qu'il y a à ma droite|what_is_right
N|qu'y a-t-il derrière moi|what_is_behind
N|qu'y a-t-il devant moi|what_is_ahead
N|y a-t-il quelque chose devant|what_is_ahead
N|où puis-je m'asseoir|where_to_sit
N|la voie est libre|what_is_ahead
N|où est ma montre|unknown: where_is montre
N|ou est le refrigerateur|where_is fridge
)"},
}};
// These were kept apart and are only counted.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kSayingsKeptApart{{
    {"en", R"(
L|no I want to go to the hall|take_me_to corridor
L|no no, the bathroom|take_me_to bathroom
L|I said the living room|take_me_to living room
L|I mean the hall, not the kitchen|take_me_to corridor
L|wrong, the bathroom please|take_me_to bathroom
L|actually the bathroom|take_me_to bathroom
L|take me to the living room instead of the kitchen|take_me_to living room
L|oh no, not the kitchen|pause
L|no, that's wrong|pause
L|no wait|pause
L|please cancel that now|end
L|stop, I meant the hall|pause
L|rather the bathroom|take_me_to bathroom
P|I meant the lamp|where_is lamp
P|no, the lamp|where_is lamp
Q|sorry, I meant the sofa|where_is sofa
Q|no, where is the lamp|where_is lamp
W|the one on my left|take_me_to bedroom 1
W|the right one please|take_me_to bedroom 2
W|whichever is closer|take_me_to bedroom 1
W|none of them|declined
W|neither one, thanks|declined
W|the fourth|offer
W|forget it|declined
W|not bedroom 1|take_me_to bedroom 2
W|the last one|take_me_to bedroom 2
M|the living room one|take_me_to chair in living room
M|the one that's further away|take_me_to chair in living room
M|no, in the living room|take_me_to chair in living room
M|the left one|take_me_to chair in kitchen
D|no, not the kitchen, the bathroom|take_me_to bathroom
D|the second one|offer
X|no, I want the other one|take_me_to bedroom 2
X|not that one, the other|take_me_to bedroom 2
N|is there something on my right|what_is_right
N|what have I got on my left|what_is_left
N|tell me what is behind me|what_is_behind
N|anything in front of me|what_is_ahead
N|is the path clear|what_is_ahead
N|can I sit somewhere|where_to_sit
N|is there somewhere to sit down|where_to_sit
N|I would like to sit down|where_to_sit
N|can you find my glasses case|unknown: where_is glasses case
)"},
    {"de", R"(
L|nein, ich will in den Flur|take_me_to corridor
L|nee, ins Bad bitte|take_me_to bathroom
L|ich habe Wohnzimmer gesagt|take_me_to living room
L|falsch, ins Bad|take_me_to bathroom
L|stattdessen ins Bad|take_me_to bathroom
L|ich meine das Bad, nicht die Küche|take_me_to bathroom
L|Entschuldigung, ich meinte den Flur|take_me_to corridor
L|ach nein, nicht zur Küche|pause
L|nein, das ist falsch|pause
L|nein warte|pause
L|bitte sofort abbrechen|end
L|halt, ich meinte das Bad|pause
L|lieber ins Wohnzimmer|take_me_to living room
P|ich meinte die Lampe|where_is lamp
P|nein, die Lampe|where_is lamp
Q|Verzeihung, das Sofa meinte ich|where_is sofa
Q|nein, wo ist die Lampe|where_is lamp
W|das links von mir|take_me_to bedroom 1
W|das rechte bitte|take_me_to bedroom 2
W|was näher ist|take_me_to bedroom 1
W|keines|declined
W|weder noch|declined
W|das vierte|offer
W|vergiss es|declined
W|nicht Schlafzimmer 1|take_me_to bedroom 2
W|das letzte|take_me_to bedroom 2
M|der Wohnzimmerstuhl|take_me_to chair in living room
M|der weiter weg ist|take_me_to chair in living room
M|nein, im Wohnzimmer|take_me_to chair in living room
M|der linke|take_me_to chair in kitchen
D|nein, nicht die Küche, das Bad|take_me_to bathroom
D|das zweite|offer
X|nein, ich will das andere|take_me_to bedroom 2
X|nicht das, das andere|take_me_to bedroom 2
N|ist rechts von mir etwas|what_is_right
N|was habe ich zu meiner Linken|what_is_left
N|sag mir was hinter mir steht|what_is_behind
N|gibt es etwas vor mir|what_is_ahead
N|ist vor mir alles frei|what_is_ahead
N|kann ich mich irgendwo setzen|where_to_sit
N|wo gibt es einen Sitzplatz|where_to_sit
N|ich möchte mich setzen|where_to_sit
N|wo habe ich mein Brillenetui|unknown: where_is Brillenetui
N|was fuer ein Raum ist das|where_am_i
N|fuehre mich zur Tuer|take_me_to door
)"},
    {"es", R"(
L|no, quiero ir al pasillo|take_me_to corridor
L|que no, al baño|take_me_to bathroom
L|he dicho el salón|take_me_to living room
L|no a la cocina sino al baño|take_me_to bathroom
L|al baño en vez de a la cocina|take_me_to bathroom
L|me equivoqué, al pasillo|take_me_to corridor
L|mal, al baño|take_me_to bathroom
L|no, a la cocina no|pause
L|no, está mal|pause
L|no espera|pause
L|cancela eso por favor|end
L|para, quería decir el baño|pause
L|prefiero el salón|take_me_to living room
P|quería decir la lámpara|where_is lamp
P|no, la lámpara|where_is lamp
Q|perdona, quería decir el sofá|where_is sofa
Q|no, dónde está la lámpara|where_is lamp
W|el izquierdo|take_me_to bedroom 1
W|el que está a mi derecha|take_me_to bedroom 2
W|el que esté más cerca|take_me_to bedroom 1
W|ninguno de los dos|declined
W|ni uno ni otro|declined
W|el cuarto|offer
W|olvídalo|declined
W|el dormitorio 1 no|take_me_to bedroom 2
W|el último|take_me_to bedroom 2
M|la silla del salón|take_me_to chair in living room
M|la más lejana|take_me_to chair in living room
M|no, en el salón|take_me_to chair in living room
M|la de la izquierda|take_me_to chair in kitchen
D|no, la cocina no, el baño|take_me_to bathroom
D|el segundo|offer
X|no, quiero el otro|take_me_to bedroom 2
X|ese no, el otro|take_me_to bedroom 2
N|hay algo a mi derecha|what_is_right
N|qué cosas tengo a mi izquierda|what_is_left
N|dime qué hay detrás|what_is_behind
N|hay algo enfrente de mí|something_ahead
N|puedo pasar por aquí|what_is_ahead
N|hay algún sitio para sentarse|where_to_sit
N|en dónde me puedo sentar|where_to_sit
N|quiero sentarme|where_to_sit
N|dónde están mis gafas|unknown: where_is gafas
N|hay algo en la mesa|what_is_on table
N|qué cosas hay en mi mesa|what_is_on table
)"},
    {"fr", R"(
L|non, je veux aller dans le couloir|take_me_to corridor
L|mais non, la salle de bain|take_me_to bathroom
L|j'ai dit le salon|take_me_to living room
L|la salle de bain, pas la cuisine|take_me_to bathroom
L|la salle de bain au lieu de la cuisine|take_me_to bathroom
L|je me suis trompé, le couloir|take_me_to corridor
L|finalement, la salle de bain|take_me_to bathroom
L|ah non, pas la cuisine|pause
L|non, c'est faux|pause
L|non attends|pause
L|annule ça s'il te plaît|end
L|stop, je voulais dire le salon|pause
L|je préfère le salon|take_me_to living room
P|je voulais dire la lampe|where_is lamp
P|non, la lampe|where_is lamp
Q|désolé, je voulais dire le canapé|where_is sofa
Q|non, où est la lampe|where_is lamp
W|celle qui est à gauche|take_me_to bedroom 1
W|celle à ma droite|take_me_to bedroom 2
W|la moins loin|take_me_to bedroom 1
W|aucune des deux|declined
W|ni l'une ni l'autre|declined
W|la quatrième|offer
W|laisse tomber|declined
W|pas la chambre 1|take_me_to bedroom 2
W|la dernière|take_me_to bedroom 2
M|la chaise du salon|take_me_to chair in living room
M|la plus éloignée|take_me_to chair in living room
M|non, dans le salon|take_me_to chair in living room
M|celle de gauche|take_me_to chair in kitchen
D|non, pas la cuisine, la salle de bain|take_me_to bathroom
D|la deuxième|offer
X|non, je veux l'autre|take_me_to bedroom 2
X|pas celle-là, l'autre|take_me_to bedroom 2
N|il y a quelque chose à droite|what_is_right
N|j'ai quoi à ma gauche|what_is_left
N|dis-moi ce qu'il y a derrière moi|what_is_behind
N|il y a quoi en face de moi|what_is_ahead
N|est-ce que le passage est libre|what_is_ahead
N|je peux m'asseoir où|where_to_sit
N|y a-t-il un endroit pour s'asseoir|where_to_sit
N|je voudrais m'asseoir|where_to_sit
N|où est mon étui à lunettes|unknown: where_is étui à lunettes
N|emmene moi a la cuisine|take_me_to kitchen
)"},
}};
// clang-format on

}  // namespace roomwise::guide::testing
